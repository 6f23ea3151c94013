"""The page in use: the three seats, both at once, bad inputs, a connection that is lost, keyboard and phone."""

import pytest
from browsing import GRID, browsing, serving
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from llf_teacher.studies import Study, load
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store

BANDIT = "llf-bandits-BanditTenArmedGaussian-v0"
WINDOWS = [(390, 844), (768, 1024), (1200, 900)]
"""A phone, a tablet, a screen."""


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
    assert all(visitor.text("body").count(said.text) == 1 for said in visitor.all("#said .words"))
    visitor.press("west")
    visitor.shows("#status", "Turn 1 of 3")
    visitor.shows("#did", "The student: west")
    visitor.press("Take back")
    visitor.shows("#status", "Turn 0 of 3")
    assert visitor.text("#past") == ""
    visitor.one("#answer").send_keys("west" + Keys.ENTER)
    visitor.shows("#status", "Turn 1 of 3")
    to_the_end(visitor, "west")
    visitor.shows("#end", "Over after 3 turns")
    assert visitor.all("#said .fails")
    assert visitor.all("#turns .fails")
    visitor.click("#whole")
    visitor.shows("h2", "Downloads")
    assert "✗ false" in visitor.text("ol.turns")
    assert {link.get_attribute("href").rpartition(".")[2] for link in visitor.all("a[download]")} == {
        *("json", "jsonl", "gif", "db")
    }
    visitor.click("#film")
    visitor.shows("#making", "It is being made")
    visitor.until(lambda: visitor.text("#making") == "", "film")


def test_the_teachers_seat(address, visitor):
    visitor.begin(address, seat="teacher", student="obedient", seed=7)
    boxes = visitor.all("#claims input")
    assert [box.get_attribute("type") for box in boxes] == ["checkbox"] * 2
    boxes[1].click()
    visitor.press("Say it")
    visitor.shows("#status", "Turn 1 ")
    assert "✓ true" in visitor.text("#turns > li:first-child")
    visitor.press("Say nothing")
    visitor.shows("#turns > li:nth-child(2)", "(silence)")
    to_the_end(visitor, "Let oracle speak")
    visitor.shows("#end", "solved")


def test_how_much_is_said(address, visitor):
    visitor.begin(address, seat="teacher", bits=True, seed=7)
    visitor.shows("#claims .bits", " bits")
    visitor.all("#claims input")[1].click()
    visitor.press("Say it")
    visitor.shows("#turns > li:first-child .bits", " bits")
    visitor.begin(address, seat="watch", id="llf-poem-Haiku-v0", bits=True, seed=7)
    visitor.shows("#unmeasured", "'poem' has no posterior")
    assert visitor.driver.execute_script("return document.documentElement.scrollWidth <= innerWidth")


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
    visitor.press("Take back")
    visitor.shows("#status", "Turn 0 ")
    visitor.press("Play on")
    visitor.shows("#status", "Turn 2 ")
    assert visitor.one("#play").get_attribute("aria-pressed") == "true"
    visitor.until(lambda: visitor.one("#end").is_displayed(), "end")
    assert visitor.one("#play").get_attribute("aria-pressed") == "false"


def test_both_seats(address, visitor):
    visitor.begin(address, seat="student", two=True, seed=7, max_turns=2)
    visitor.shows("#status", "Waiting for the teacher")
    with browsing() as other:
        other.driver.get(visitor.one("#link").get_attribute("href"))
        other.shows("#status", "It is your turn")
        assert not other.all("#link")
        other.all("#claims input")[0].click()
        other.press("Say it")
        visitor.shows("#status", "It is your turn")
        assert visitor.text("#said p:last-child .kind") == "advice"
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
    visitor.shows("#did", "The student: (not understood) fly to the moon")
    visitor.press("west")
    visitor.shows("#turns > li:nth-child(2)", "No action could be read from:")
    visitor.shows("#turns > li:nth-child(2) pre", "fly to the moon")
    visitor.driver.execute_script("document.getElementById('answer').maxLength = 9999")
    visitor.driver.execute_script("document.getElementById('answer').value = 'x'.repeat(5000)")
    visitor.press("Act")
    visitor.shows("#problem", "act must be a text of at most 4000 characters")
    visitor.driver.get(f"{address}seat/guess")
    visitor.shows("[role=alert]", "there is no such episode")


def test_a_connection_that_is_lost(address, visitor):
    visitor.begin(address, seat="student", two=True, seed=7)
    page = visitor.driver.current_url
    visitor.driver.set_network_conditions(offline=True, latency=0, throughput=0)
    visitor.shows("#connection", "The server cannot be reached; trying again.")
    with browsing() as other:
        other.driver.get(visitor.one("#link").get_attribute("href"))
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


def test_a_page_that_is_behind_makes_no_move(address, visitor):
    """It says so, and shows what has happened."""
    visitor.begin(address, seat="student", seed=7)
    with browsing() as other:
        other.driver.get(visitor.driver.current_url)
        other.shows("#status", "Turn 0 ")
        visitor.press("west")
        visitor.shows("#status", "Turn 1 ")
        other.press("north")
        other.shows("#problem", "the episode is at turn 1, and this was sent for turn 0")
        other.shows("#status", "Turn 1 ")
        other.shows("#did", "The student: west")


def test_stored_episodes_turn_by_turn(visitor, tmp_path):
    path = tmp_path / "study.db"
    study = Study(ids=[GRID], teachers=["mistake(eps=1)"], students=["obedient"], seeds=1, max_turns=3)
    with Store(path) as store:
        for spec in study.episodes():
            store.add(play(spec))
    with serving("--replay", path) as address:
        visitor.driver.get(address)
        visitor.click("a[href='/stored/0']")
        with browsing(390, 844) as phone:
            phone.driver.get(f"{address}stored/0")
            assert phone.inside(".episodes td")
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
    visitor.until(lambda: focus(visitor) == "status", "focus on the status")
    ActionChains(visitor.driver).send_keys(Keys.TAB).perform()
    assert visitor.driver.switch_to.active_element.text == "north"
    visitor.one("#answer").send_keys("west" + Keys.ENTER)
    visitor.shows("#status", "Turn 1 ")
    assert focus(visitor) == "answer"


def focus(visitor):
    return visitor.driver.switch_to.active_element.get_attribute("id")


def test_the_focus_stays_on_the_page(address, visitor):
    """Where it was may be gone: then it is on the line that says whose turn it is."""
    visitor.begin(address, seat="teacher", seed=7, max_turns=1)
    visitor.click("#claims input")
    visitor.press("Say it")
    visitor.shows("#status", "Turn 1 ")
    assert focus(visitor) or visitor.driver.switch_to.active_element.text == "Say it"
    visitor.press("Let oracle speak")
    visitor.shows("#end", "Over after 1 turns")
    visitor.until(lambda: focus(visitor) == "status", "focus on the status")


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
            world, talk = visitor.one("#picture").rect, visitor.one(".talk").rect
            assert world["y"] >= talk["y"] + talk["height"]
            assert world["width"] == 360
            sizes = [button.rect for button in visitor.all("button") if button.is_displayed()]
            assert min(size["height"] for size in sizes) >= 44


@pytest.mark.parametrize(("width", "height"), WINDOWS)
def test_what_there_is_to_do_is_in_view(address, width, height):
    """From the first turn on, without scrolling, with a few turns below; and nothing is wider than the window."""
    with browsing(width, height) as visitor:
        for seat, id, turns in (
            ("student", GRID, ["west"]),
            ("student", BANDIT, ["0", "9"]),
            ("student", "llf-reco-movie-v0", []),
            ("teacher", GRID, ["Say it", "Let oracle speak"]),
            ("watch", GRID, ["Next turn"]),
        ):
            visitor.begin(address, seat=seat, id=id, seed=7)
            visitor.drawn()
            for turn, name in enumerate((None, *turns)):
                if name is not None:
                    visitor.press(name)
                    visitor.shows("#status", f"Turn {turn} ")
                    visitor.driver.execute_script("scrollTo(0, 0)")
                assert visitor.inside("#status"), (seat, id, turn)
                assert visitor.inside(".do button, .do textarea, #claims label"), (seat, id, turn)
                assert visitor.inside("#said p:first-child"), (seat, id, turn)
                scale = visitor.driver.execute_script("return document.getElementById('picture').clientWidth / 384")
                assert scale > 0.95, "the letters of the picture have their size"
            assert visitor.driver.execute_script("return document.documentElement.scrollWidth") == width


@pytest.mark.parametrize(("width", "height"), WINDOWS)
def test_a_misspelled_teacher_does_not_widen_the_page(address, width, height):
    with browsing(width, height) as visitor:
        visitor.driver.get(address)
        visitor.one("#teacher").send_keys("x" * 100)
        visitor.press("Begin")
        visitor.shows("#problem", "unknown personality 'oraclexxx")
        assert visitor.driver.execute_script("return document.documentElement.scrollWidth") == width
        assert visitor.inside("#problem, button[type=submit]")


def test_what_cannot_be_chosen_looks_so(address, visitor):
    visitor.driver.get(address)
    student, teacher = visitor.one("#student"), visitor.one("#teacher")
    looks = ("background-color", "border-top-style", "color")

    def look(field):
        return [field.value_of_css_property(name) for name in looks]

    assert not student.is_enabled()
    assert not any(one == other for one, other in zip(look(student), look(teacher), strict=True))
    visitor.click("input[name=seat][value=teacher]")
    visitor.until(lambda: look(student) == look(teacher), "field that looks enabled")


def test_bandits_have_a_button_for_each_arm(address, visitor):
    visitor.begin(address, seat="student", id=BANDIT, seed=7)
    assert [button.text for button in visitor.all("#buttons button")] == [f"{arm}" for arm in range(10)]
    visitor.press("3")
    visitor.shows("#did", "The student: 3 (reward ")


def test_what_is_ticked_is_heard(address, visitor):
    visitor.begin(address, seat="student", two=True, seed=7)
    with browsing() as other:
        other.driver.get(visitor.one("#link").get_attribute("href"))
        for turn in range(3):
            other.shows("#status", f"Turn {turn} ")
            other.shows("#status", "It is your turn")
            last = other.all("#claims label")[-1]
            ticked = last.text.split(maxsplit=1)  # the kind's word, then the sentence
            last.click()
            other.press("Say it")
            visitor.shows("#status", "It is your turn")
            assert visitor.text("#said p:last-child").split(maxsplit=1) == ticked
            assert [visitor.text(f"#said p:last-child {part}") for part in (".kind", ".words")] == ticked
            visitor.press("south")


@pytest.mark.parametrize(("width", "height"), WINDOWS)
def test_a_report_shows_its_findings(width, height, tmp_path):
    """And says of what is wider than the window that it can be scrolled."""
    study = Study(ids=[GRID], teachers=["oracle", "silent"], students=["obedient", "text_only"], seeds=5, max_turns=5)
    with Store(tmp_path / "study.db") as store:
        for spec in study.episodes():
            store.add(play(spec))
    with load(tmp_path / "study.db") as results:
        (tmp_path / "report.html").write_text(results.report(study).html, encoding="utf-8")
    with browsing(width, height) as visitor:
        visitor.driver.get((tmp_path / "report.html").as_uri())
        assert visitor.driver.execute_script("return document.documentElement.scrollWidth") == width
        visitor.driver.execute_script("document.getElementById('findings').scrollIntoView()")
        (plot,) = [each for each in visitor.all("#findings-scores svg") if each.is_displayed()]
        assert 0 <= plot.rect["x"] < plot.rect["x"] + plot.rect["width"] <= width
        for text in visitor.driver.execute_script(LETTERS):
            assert text["left"] >= 0, text
            assert text["right"] <= width, text
            assert text["height"] >= 9, text
        wider, cues = visitor.driver.execute_script(
            """
            const wide = [...document.querySelectorAll(".wide")].filter((each) => each.checkVisibility());
            const cue = (each) => getComputedStyle(each, "::before").content.includes("scroll to the right");
            return [wide.map((each) => each.scrollWidth > each.clientWidth + 1), wide.map(cue)];
            """
        )
        assert wider == cues
        assert any(wider) or width > 390


LETTERS = """
const shown = [...document.querySelectorAll("#findings text, #findings li")].filter((each) => each.checkVisibility());
return shown.map((each) => {
  const { left, right, height } = each.getBoundingClientRect();
  return { left, right, height, text: each.textContent };
});
"""


def test_nothing_is_asked_of_another_place(address, visitor):
    visitor.begin(address, seat="watch", seed=7)
    visitor.drawn()
    asked = visitor.driver.execute_script("return performance.getEntriesByType('resource').map((each) => each.name)")
    assert len(asked) >= 5
    assert all(name.startswith(address) for name in asked)
    refused = "return fetch('https://example.org/').then(() => 'let', () => 'refused')"
    assert visitor.driver.execute_script(refused) == "refused"
    assert any("Content Security Policy" in entry["message"] for entry in visitor.driver.get_log("browser"))
