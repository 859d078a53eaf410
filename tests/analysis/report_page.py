"""A report in headless Chromium, and what every report must hold to."""
import base64
import pathlib
import shutil
import sys
import time

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    print("python3-selenium is not installed")
    sys.exit(77)

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not CHROMIUM or not DRIVER:
    print("chromium or chromium-driver is not installed")
    sys.exit(77)

failures = []


def check(holds, what):
    if not holds:
        failures.append(what)
        print("FAILED:", what)


class Page:
    def __init__(self, path, kind, shots, width, height):
        self.kind = kind
        self.shots = shots
        options = Options()
        options.binary_location = CHROMIUM
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         f"--window-size={width},{height}", "--hide-scrollbars"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        self.driver.set_page_load_timeout(120)
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        self.width = width
        start = time.time()
        self.driver.get(pathlib.Path(path).resolve().as_uri())
        self.load_seconds = time.time() - start

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def wait(self, what, condition, seconds=30):
        try:
            WebDriverWait(self.driver, seconds, 0.05).until(lambda _: condition())
        except Exception:  # selenium's timeout, or an element that never came
            check(False, f"{self.width}: {what}")
            return False
        return True

    def show(self, element):
        self.script("arguments[0].scrollIntoView({block: 'center'})", element)

    # What a canvas shows, as text to compare.
    def pixels(self, canvas):
        return self.script("return arguments[0].toDataURL()", canvas)

    def changes(self, what, canvas, act):
        before = self.pixels(canvas)
        act()
        self.wait(what, lambda: self.pixels(canvas) != before)

    def shot(self, name):
        if not self.shots:
            return
        folder = pathlib.Path(self.shots)
        folder.mkdir(parents=True, exist_ok=True)
        size = self.script("return [innerWidth, document.documentElement.scrollHeight]")
        data = self.driver.execute_cdp_cmd("Page.captureScreenshot", {
            "captureBeyondViewport": True,
            "clip": {"x": 0, "y": 0, "width": size[0], "height": min(size[1], 16000), "scale": 1}})
        (folder / f"{name}-{self.width}.png").write_bytes(base64.b64decode(data["data"]))


def labelled(page, text, within="body"):
    """The control that a label of this text names."""
    for label in page.all(f"{within} label"):
        if label.find_element(By.TAG_NAME, "span").text == text:
            return label.find_element(By.CSS_SELECTOR, "select, input")
    raise AssertionError(f"no control is labelled {text}")


def check_whole_page(page):
    """What every report must hold to."""
    logs = [entry["message"] for entry in page.driver.get_log("browser")]
    check(not logs, f"{page.width}: the console is empty: {logs[:3]}")
    check(page.script("return document.documentElement.scrollWidth <= innerWidth"),
          f"{page.width}: nothing sticks out to the right")
    small = page.script("""
        const walker = document.createTreeWalker(document.querySelector('main'), NodeFilter.SHOW_TEXT);
        const small = [];
        while (walker.nextNode()) {
          const box = walker.currentNode.parentElement;
          if (walker.currentNode.textContent.trim() && box.offsetParent && parseFloat(getComputedStyle(box).fontSize) < 11)
            small.push(walker.currentNode.textContent);
        }
        return small;""")
    check(not small, f"{page.width}: no text smaller than 11 pixels: {small[:3]}")
    unnamed = page.script("""
        return [...document.querySelectorAll('main input, main select, main button, main canvas, main img')]
          .filter((box) => !(box.labels && box.labels.length) && !box.getAttribute('aria-label') && !box.textContent.trim() &&
            box.getAttribute('alt') === null)
          .map((box) => box.outerHTML.slice(0, 80));""")
    check(not unnamed, f"{page.width}: every control and picture has a name: {unnamed[:3]}")


def check_scripts_end(page):
    """Dark colours, print, and the console again after everything."""
    light = page.script("return getComputedStyle(document.body).backgroundColor")
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
        "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    dark = page.script("return getComputedStyle(document.body).backgroundColor")
    check(light != dark, f"{page.width}: a dark page for who prefers it")
    page.shot(page.kind + "-dark")
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    paper = page.driver.execute_cdp_cmd("Page.printToPDF", {})
    check(base64.b64decode(paper["data"]).startswith(b"%PDF"), f"{page.width}: prints")
    if page.shots:
        (pathlib.Path(page.shots) / f"{page.kind}-{page.width}.pdf").write_bytes(base64.b64decode(paper["data"]))
    check_whole_page(page)
