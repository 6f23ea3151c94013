"""A real browser, and a server for it. `python tests/helpers/browsing.py docs` takes the pictures of the page."""

import contextlib
import io
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException, TimeoutException
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select, WebDriverWait

HOW = (
    "a browser is needed, Chromium and its driver: on Debian `apt-get install chromium chromium-driver`, then "
    '`pip install -e ".[all,test,browser]" -c constraints.txt`; or name them by LLF_BROWSER and LLF_BROWSER_DRIVER'
)
SECONDS = 30
GRID = "llf-gridworld-v0"


def found(setting, *names):
    """The path of a program, by a setting or its usual names."""
    named = os.environ.get(setting, "")
    path = named if os.path.isfile(named) else next(filter(None, map(shutil.which, names)), None)
    if path is None:
        raise RuntimeError(f"found no {names[0]}. {HOW}")
    return path


def programs():
    """The paths of a browser and of its driver.

    Raises:
        RuntimeError: one is missing; says how to get it.
    """
    browser = found("LLF_BROWSER", "chromium", "chromium-browser", "google-chrome")
    return browser, found("LLF_BROWSER_DRIVER", "chromedriver")


@contextlib.contextmanager
def serving(*arguments):
    """`llf serve` at a free port; gives its address."""
    command = [sys.executable, "-m", "llf_teacher", "serve", "--port", "0", *map(str, arguments)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        address = server.stdout.readline().strip()
        assert address.startswith("http://"), address
        yield address
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(SECONDS)
        server.stdout.close()


@contextlib.contextmanager
def browsing(width=1100, height=900, dark=False):
    """A browser without a window on a screen."""
    options = webdriver.ChromeOptions()
    options.binary_location, driven_by = programs()
    for argument in (
        "--headless=new",
        "--disable-dev-shm-usage",
        "--hide-scrollbars",
        f"--window-size={width},{height}",
    ):
        options.add_argument(argument)
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        options.add_argument("--no-sandbox")  # which the superuser cannot have
    if width < 500:  # no window can be so small
        options.add_experimental_option("mobileEmulation", {"deviceMetrics": {"width": width, "height": height}})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(driven_by)
    driver = webdriver.Chrome(options, service)
    try:
        if dark:
            features = [{"name": "prefers-color-scheme", "value": "dark"}]
            driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        yield Visitor(driver)
    finally:
        driver.quit()


class Visitor:
    """Somebody at a browser."""

    def __init__(self, driver):
        self.driver = driver

    def one(self, selector):
        """An element, as soon as it is there: a click may have asked for another page."""
        return self.until(lambda: self.driver.find_element(By.CSS_SELECTOR, selector), selector)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def text(self, selector):
        """What can be read there, asked for in one go: the page may change meanwhile."""
        script = "const e = document.querySelector(arguments[0]); return e && e.checkVisibility() ? e.innerText : ''"
        return self.driver.execute_script(script, selector)

    def until(self, condition, what):
        """Wait for something; an element that is not there yet, or of a page that is left, is tried again."""
        wait = WebDriverWait(self.driver, SECONDS, 0.05, [StaleElementReferenceException])
        try:
            return wait.until(lambda _: condition())
        except TimeoutException:
            raise AssertionError(f"no {what}: {self.text('body')}") from None

    def shows(self, selector, text):
        """Wait until a text is in an element."""
        self.until(lambda: text in self.text(selector), f"{text!r} in {selector}")

    def click(self, selector):
        self.until(lambda: self._clicked(self.all(selector)[:1]), selector)

    def press(self, name):
        """Click the button of a name that is shown."""

        def named():
            return [each for each in self.all("button") if each.is_displayed() and each.text == name]

        self.until(lambda: self._clicked(named()), f"one button {name!r}")

    def _clicked(self, elements):
        """Whether there was one element, which has been clicked."""
        if len(elements) != 1:
            return False
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", elements[0])
        elements[0].click()
        return True

    def begin(self, address, *, seat="student", id=GRID, **fields):
        """Choose a lesson, and come to its page."""
        self.driver.get(address)
        Select(self.one("#id")).select_by_visible_text(id)
        self.click(f"input[name=seat][value={seat}]")
        if fields.pop("two", False):
            self.click("input[name=two]")
        if fields.pop("bits", False):
            self.click("input[name=bits]")
        if fields.pop("own_words", False):
            self.click("input[value='own words']")
        if "max_turns" in fields:
            self.click("form summary")
        for name, value in fields.items():
            field = self.one(f"#{name}")
            field.clear()
            field.send_keys(str(value))
        self.press("Begin")
        self.until(lambda: "/seat/" in self.driver.current_url, "page of a seat")
        self.shows("#status", "Turn 0")

    def inside(self, selector):
        """Whether all elements that are shown lie in the window, and nothing lies on them."""
        return self.driver.execute_script(
            """
            const shown = [...document.querySelectorAll(arguments[0])].filter((each) => each.checkVisibility());
            return shown.length > 0 && shown.every((each) => {
              const { left, top, right, bottom } = each.getBoundingClientRect();
              if (left < 0 || top < 0 || right > innerWidth || bottom > innerHeight) return false;
              const [x, y] = [(left + right) / 2, (top + bottom) / 2];
              const above = document.elementFromPoint(x, y);
              return above !== null && (each.contains(above) || above.contains(each));
            });
            """,
            selector,
        )

    def drawn(self):
        """Wait until the picture is there."""
        script = "const p = document.getElementById('picture'); return p.complete && p.naturalWidth"
        self.until(lambda: self.driver.execute_script(script) == 768, "picture")


def take_pictures(folder):
    """The page in the three seats, as small PNGs."""
    with serving() as address, browsing(1100, 1040) as visitor:
        for seat, play in {
            "student": [lambda: visitor.press("west")],
            "teacher": [lambda: visitor.press("Let oracle speak")],
            "watch": [lambda: visitor.press("Next turn")] * 2,
        }.items():
            teacher = "oracle" if seat == "teacher" else "mistake(eps=0.4)"
            visitor.begin(address, seat=seat, teacher=teacher, seed=7)
            for turn, move in enumerate(play, 1):
                move()
                visitor.shows("#status", f"Turn {turn} ")
            visitor.drawn()
            visitor.driver.execute_script("document.activeElement.blur(); scrollTo(0, 0)")
            path = Path(folder) / f"in-the-browser-{seat}.png"
            image = Image.open(io.BytesIO(visitor.driver.get_screenshot_as_png())).convert("RGB")
            image.quantize(192, dither=Image.Dither.NONE).save(path, optimize=True)
            print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    take_pictures(sys.argv[1])
