"""The page as people use it: the three seats, two people, bad inputs, a connection that is lost, keyboard and phone."""

from browsing import GRID, browsing, serving
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from llf_teacher.studies import Study
from llf_teacher.studies.execution.play import play
from llf_teacher.studies.store import Store


def to_the_end(visitor, name):
    turn = 0
    while not visitor.one("#end").is_displayed():
        known = visitor.text("#status")
        visitor.press(name)
        visitor.until(lambda known=known: visitor.text("#status") != known, f"turn after {known}")
        turn += 1
    return turn


def test_the_students_seat(address, visitor):
    visitor.begin(address, seat="student", teacher="mistake(eps=1)", seed=7, max_turns=3)
    visitor.drawn()
    assert "You are in a house of many rooms" in visitor.text("#said")
    assert [button.text for button in visitor.all("#buttons button")] == ["north", "east", "west", "south"]
    assert not visitor.all(".holds, .fails:not(:empty), .claim")
    visitor.press("west")
    visitor.shows("#status", "Turn 1 of 3")
    visitor.shows("#turns > li:last-child", "west")
    visitor.press("Take the last turn back")
    visitor.shows("#status", "Turn 0 of 3")
    assert len(visitor.all("#turns > li")) == 1
    visitor.one("#answer").send_keys("west" + Keys.ENTER)
    visitor.shows("#status", "Turn 1 of 3")
    to_the_end(visitor, "west")
    visitor.shows("#end", "Over after 3 turns")
    assert visitor.all("#turns .fails")
    visitor.click("#whole")
    visitor.shows("h2", "To take along")
    assert "✗ false" in visitor.text("ol.turns")
    assert {link.get_attribute("href").rpartition(".")[2] for link in visitor.all("a[download]")} == {
        *("json", "jsonl", "gif", "db")
    }


def test_the_teachers_seat(address, visitor):
    visitor.begin(address, seat="teacher", student="obedient", seed=7)
    boxes = visitor.all("#claims input")
    assert [box.get_attribute("type") for box in boxes] == ["checkbox"] * 2
    boxes[1].click()
    visitor.press("Say it")
    visitor.shows("#status", "Turn 1 ")
    assert "✓ true" in visitor.text("#turns > li:first-child")
    visitor.press("Say nothing")
    visitor.shows("#turns > li:last-child", "(silence)")
    to_the_end(visitor, "Let oracle speak")
    visitor.shows("#end", "solved")


def test_words_of_ones_own_are_text(address, visitor):
    visitor.begin(address, seat="teacher", own_words=True, seed=7, max_turns=2)
    visitor.shows("#suggestion", "It would say: You are in a house")
    visitor.one("#words-own").send_keys("<img src=x onerror=alert(1)> go on")
    visitor.press("Say it")
    visitor.shows("#turns > li:first-child", "<img src=x onerror=alert(1)> go on")
    assert len(visitor.all("img")) == 1


def test_who_watches(address, visitor):
    visitor.begin(address, seat="watch", seed=7)
    visitor.press("Next turn")
    visitor.shows("#status", "Turn 1 ")
    visitor.press("Take the last turn back")
    visitor.shows("#status", "Turn 0 ")
    visitor.press("Play on")
    visitor.shows("#status", "Turn 2 ")
    assert visitor.one("#play").get_attribute("aria-pressed") == "true"
    visitor.until(lambda: visitor.one("#end").is_displayed(), "end")
    assert visitor.one("#play").get_attribute("aria-pressed") == "false"


def test_two_people(address, visitor):
    visitor.begin(address, seat="student", two=True, seed=7, max_turns=2)
    visitor.shows("#status", "Waiting for the teacher")
    with browsing() as other:
        other.driver.get(visitor.one("#link").get_attribute("value"))
        other.shows("#status", "It is your turn")
        assert not other.all("#link")
        other.all("#claims input")[0].click()
        other.press("Say it")
        visitor.shows("#status", "It is your turn")
        assert visitor.text("#said").splitlines()[-1].startswith("fp")
        visitor.press("west")
        visitor.shows("#status", "Waiting for the teacher")
        other.shows("#status", "Turn 1 of 2, reward 0 in all. It is your turn")
        other.press("Say nothing")
        visitor.shows("#said", "(silence)")
        visitor.shows("#status", "It is your turn")
        visitor.press("west")
        other.shows("#status", "Turn 2 of 2")
        other.press("Let oracle speak")
        for each in (visitor, other):
            each.shows("#end", "Over after 2 turns")


def test_bad_inputs_are_answered_by_sentences(address, visitor):
    visitor.driver.get(address)
    teacher = visitor.one("#teacher")
    teacher.clear()
    teacher.send_keys("orakle")
    visitor.press("Begin")
    visitor.shows("#problem", "'orakle'")
    assert visitor.one("button[type=submit]").is_enabled()
    visitor.begin(address, seat="student", seed=7)
    visitor.one("#answer").send_keys("fly to the moon" + Keys.ENTER)
    visitor.shows("#turns > li:last-child", "No action could be read from:")
    visitor.shows("#turns > li:last-child pre", "fly to the moon")
    visitor.driver.execute_script("document.getElementById('answer').maxLength = 9999")
    visitor.driver.execute_script("document.getElementById('answer').value = 'x'.repeat(5000)")
    visitor.press("Act")
    visitor.shows("#problem", "act must be a text of at most 4000 characters")
    visitor.driver.get(f"{address}seat/guess")
    visitor.shows("[role=alert]", "there is no such lesson")


def test_a_connection_that_is_lost(address, visitor):
    visitor.begin(address, seat="student", two=True, seed=7)
    page = visitor.driver.current_url
    visitor.driver.set_network_conditions(offline=True, latency=0, throughput=0)
    visitor.shows("#connection", "The server cannot be reached; trying again.")
    with browsing() as other:
        other.driver.get(visitor.one("#link").get_attribute("value"))
        other.shows("#status", "It is your turn")
        other.press("Let oracle speak")
        other.shows("#status", "Waiting for the student")
        other.driver.refresh()
        other.shows("#status", "Waiting for the student")
    visitor.driver.set_network_conditions(offline=False, latency=0, throughput=-1)
    visitor.shows("#status", "It is your turn")
    assert visitor.text("#connection") == ""
    visitor.driver.get("about:blank")
    visitor.driver.get(page)
    visitor.shows("#status", "It is your turn")
    assert len(visitor.all("#turns > li")) == 1


def test_people_agree_first(visitor, tmp_path):
    (tmp_path / "consent.txt").write_text("We keep what you do <here>.")
    store = tmp_path / "people.db"
    with serving("--consent", tmp_path / "consent.txt", "--codes", "--store", store) as address:
        visitor.driver.get(address)
        visitor.one("#max_turns")
        visitor.driver.execute_script("document.querySelector('form details').open = true")
        visitor.one("#max_turns").send_keys("1")
        visitor.press("Begin")
        visitor.shows("#consent", "We keep what you do <here>.")
        assert not visitor.one("#lesson").is_displayed()
        visitor.press("Sit down")
        visitor.shows("#problem-sit", "you must agree")
        visitor.click("input[name=agreed]")
        visitor.one("#participant").send_keys("p07" + Keys.ENTER)
        visitor.until(lambda: visitor.one("#lesson").is_displayed(), "lesson")
        visitor.press("west")
        visitor.shows("#end", "It is in the study.")
    with Store(store) as written:
        assert [row["student"] for row in written.rows()] == ["llf_teacher.people:PersonLearning(code='p07')"]


def test_stored_episodes_turn_by_turn(visitor, tmp_path):
    path = tmp_path / "study.db"
    study = Study(ids=[GRID], teachers=["mistake(eps=1)"], students=["obedient"], seeds=1, max_turns=3)
    with Store(path) as store:
        for spec in study.episodes():
            store.add(play(spec))
    with serving("--replay", path) as address:
        visitor.driver.get(address)
        visitor.click("a[href='/stored/0']")
        visitor.one("#q").send_keys("obedient" + Keys.ENTER)
        visitor.until(lambda: visitor.driver.current_url.endswith("q=obedient"), "page of the episodes found")
        visitor.click("tbody a")
        visitor.shows("#place", "turn 3 of 3")
        visitor.press("Back")
        visitor.shows("#place", "turn 2 of 3")
        ActionChains(visitor.driver).send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_RIGHT).perform()
        visitor.shows("#place", "turn 1 of 3")
        assert sum(turn.is_displayed() for turn in visitor.all("ol.turns > li")) == 2


def test_the_keyboard_is_enough(address, visitor):
    """Everything that can be used is reached by Tab, in the order of the page, and can be seen to be."""
    visitor.driver.get(address)
    reached = []
    for _ in range(12):
        ActionChains(visitor.driver).send_keys(Keys.TAB).perform()
        focused = visitor.driver.switch_to.active_element
        reached.append(focused.get_attribute("id") or focused.get_attribute("name") or focused.text)
        assert focused.value_of_css_property("outline-style") == "solid", reached
        if focused.text == "Begin":
            break
    assert reached == ["id", "seat", "two", "teacher", "seed", "More", "Begin"]
    focused.send_keys(Keys.ENTER)
    visitor.until(lambda: "/seat/" in visitor.driver.current_url, "page of a seat")
    visitor.shows("#status", "It is your turn")
    visitor.one("#answer").send_keys("west" + Keys.ENTER)
    visitor.shows("#status", "Turn 1 ")
    assert visitor.driver.switch_to.active_element == visitor.one("#answer")


def test_a_screen_reader_is_told_all(address, visitor):
    """Whatever can be used or seen has a name, and what the teacher says is announced."""
    for seat in ("student", "teacher", "watch"):
        visitor.begin(address, seat=seat, seed=7)
        nodes = visitor.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
        used = ("button", "checkbox", "combobox", "textbox", "link", "image", "radio", "spinbutton")
        shown = [node for node in nodes if not node["ignored"] and node["role"]["value"] in used]
        assert len(shown) > 3
        assert not [node for node in shown if not node["name"]["value"].strip()], seat
        assert visitor.one("#said").get_attribute("aria-live") == "polite"
        assert visitor.one("html").get_attribute("lang") == "en"


def test_a_phone_shows_one_column(address):
    with browsing(360, 740) as visitor:
        for seat in ("student", "teacher", "watch"):
            visitor.begin(address, seat=seat, seed=7)
            visitor.drawn()
            wide = visitor.driver.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
            assert wide == [360, 360]
            world, talk = (section.rect for section in visitor.all("#lesson > section"))
            assert world["x"] == talk["x"]
            assert talk["y"] >= world["y"] + world["height"]
            sizes = [button.rect for button in visitor.all("button") if button.is_displayed()]
            assert min(size["height"] for size in sizes) >= 44


def test_nothing_is_asked_of_another_place(address, visitor):
    visitor.begin(address, seat="watch", seed=7)
    visitor.drawn()
    asked = visitor.driver.execute_script("return performance.getEntriesByType('resource').map((each) => each.name)")
    assert len(asked) >= 5
    assert all(name.startswith(address) for name in asked)
    refused = "return fetch('https://example.org/').then(() => 'let', () => 'refused')"
    assert visitor.driver.execute_script(refused) == "refused"
    assert any("Content Security Policy" in entry["message"] for entry in visitor.driver.get_log("browser"))
