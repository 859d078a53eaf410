#!/usr/bin/python3
"""Opens a report in headless Chromium and uses it as a reader does, by clicks and keys, at 1280 and 390 pixels.

report_browser.py KIND PAGE [--pixel X,Y --fragments N] [--shots DIR]     KIND: compare, claims, bench, validate
Exit 0 all holds, 1 with a line for each thing that does not, 77 where browser or driver is not installed.
"""
import argparse
import sys

from report_page import Page, check, check_scripts_end, check_whole_page, failures, labelled  # exits 77 without a browser

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select


def plot_numbers(page, plot):
    """The plot's own table: heading -> number of each row, None where there is none."""
    return page.script("""
        const table = arguments[0].querySelector('details table');
        const names = [...table.tHead.rows[0].cells].map((cell) => cell.dataset.name);
        return [...table.tBodies[0].rows].map((row) => Object.fromEntries([...row.cells].map((cell, i) =>
          [names[i], table.tHead.rows[0].cells[i].dataset.kind !== 'number' ? cell.textContent :
            cell.dataset.value === undefined ? null : Number(cell.dataset.value)])));""", plot)


def pareto(rows, x, y):
    """By the definition: nothing is at least as good in both and better in one."""
    points = [row for row in rows if row[x] is not None and row[y] is not None]
    def beaten(p):
        return any(q[x] <= p[x] and q[y] <= p[y] and (q[x] < p[x] or q[y] < p[y]) for q in points)
    return sorted(p["name"] for p in points if not beaten(p))


def check_plot(page, x, y, other):
    """Axes `x` and `y` where smaller is better, and a third."""
    plot = page.find("figure.plot")
    page.show(plot)
    if not page.wait("the plot starts", lambda: plot.find_elements(By.TAG_NAME, "canvas")):
        return
    canvas = plot.find_element(By.TAG_NAME, "canvas")
    page.show(canvas)
    rows = plot_numbers(page, plot)
    across = Select(labelled(page, "across", "figure.plot"))
    up = Select(labelled(page, "up", "figure.plot"))
    across.select_by_value(x)
    up.select_by_value(y)
    said = plot.find_element(By.CSS_SELECTOR, ".said").text
    fronts = {part.split(": ")[0]: sorted(part.split(": ", 1)[1].split(" · ")) for part in said.split(". ")[0].split("; ")}
    if "scene" in rows[0]:
        expected = {f"Pareto front of {scene}": pareto([row for row in rows if row["scene"] == scene], x, y)
                    for scene in {row["scene"] for row in rows}}
    else:
        expected = {"Pareto front": pareto(rows, x, y)}
    check(fronts == expected, f"{page.width}: the Pareto front of {x} and {y}: {fronts}, {expected}")
    page.changes("another axis, another plot", canvas, lambda: across.select_by_value(other))
    check(page.script("return arguments[0].plot.chart.options.scales.x.title.text", plot).startswith(other),
          f"{page.width}: the axis is named")
    page.changes("a logarithmic scale", canvas, lambda: plot.find_elements(By.CSS_SELECTOR, ".check input")[0].click())
    plot.find_elements(By.CSS_SELECTOR, ".check input")[0].click()
    page.changes("without the front", canvas, lambda: plot.find_elements(By.CSS_SELECTOR, ".check input")[-1].click())
    # Hover: over the first point of the first group.
    page.show(canvas)
    spot = page.script("""const chart = arguments[0].plot.chart, shape = chart.getDatasetMeta(0).data[0];
        return [shape.x - chart.width / 2, shape.y - chart.height / 2, chart.data.datasets[0].data[0].name];""", plot)
    ActionChains(page.driver).move_to_element_with_offset(canvas, int(spot[0]), int(spot[1])).perform()
    named = lambda: page.script("const tip = arguments[0].plot.chart.tooltip; return tip.opacity > 0 && tip.title.join()", plot)
    page.wait("a tooltip names the point", named)
    names = page.script("return arguments[0].plot.chart.data.datasets.flatMap((set) => set.data.map((point) => point.name))", plot)
    check(named() in names, f"{page.width}: the tooltip names {spot[2]}: {named()}")
    # Keys step through the points.
    canvas.send_keys(Keys.ARROW_RIGHT)
    first = plot.find_element(By.CSS_SELECTOR, ".said").text
    canvas.send_keys(Keys.ARROW_RIGHT)
    second = plot.find_element(By.CSS_SELECTOR, ".said").text
    check(first != second and first.split(": ")[0], f"{page.width}: arrow keys say the next point: {first} / {second}")


def check_viewer(page, layers):
    views = page.find(".views")
    page.show(views)
    if not page.wait("the viewer starts", lambda: page.script("return Boolean(arguments[0].views)", views)):
        return None
    page.driver.execute_async_script("arguments[0].views.ready.then(arguments[1])", views)
    left, right = views.find_elements(By.CSS_SELECTOR, ".pane canvas")
    slider = views.find_element(By.CSS_SELECTOR, "input[type=range]")
    technique = Select(labelled(page, "technique", ".views"))
    page.show(left)
    # All the reference on one end, all the technique on the other.
    slider.send_keys(Keys.HOME)
    reference = page.pixels(left)
    page.changes("the slider shows the technique", left, lambda: slider.send_keys(Keys.END))
    chosen = technique.first_selected_option.text
    another = next(option.text for option in technique.options if option.text != chosen)
    page.changes("another technique", left, lambda: technique.select_by_visible_text(another))
    slider.send_keys(Keys.HOME)
    check(arguments.kind == "validate" or page.pixels(left) == reference,
          f"{page.width}: all techniques have one reference")
    slider.send_keys(Keys.END)
    width = left.size["width"]
    page.show(left)
    ActionChains(page.driver).move_to_element_with_offset(left, width // 2 - 3, 0).click_and_hold().move_by_offset(
        -width // 4, 0).release().perform()
    check(0.1 < int(slider.get_attribute("value")) / 1000 < 0.9, f"{page.width}: the line can be dragged")
    layer = Select(labelled(page, "beside it", ".views"))
    for name in layers:
        page.changes(f"beside it: {name}", right, lambda name=name: layer.select_by_visible_text(name))
    # Zoom and pointer are of both.
    for canvas in (left, right):
        before = page.pixels(right if canvas is left else left)
        page.show(canvas)
        canvas.send_keys("+")
        page.wait("both zoom", lambda: page.pixels(right if canvas is left else left) != before)
    before = page.pixels(right)
    ActionChains(page.driver).move_to_element_with_offset(left, 11, 7).perform()
    page.wait("the other picture marks the pixel", lambda: page.pixels(right) != before)
    page.wait("values of the pixel", lambda: "sRGB" in views.find_element(By.CSS_SELECTOR, ".readout").text)
    left.send_keys("0")
    return views


def check_inspector(page, views):
    panel = lambda: views.find_element(By.CSS_SELECTOR, ".inspector .panel").text
    menu = Select(labelled(page, "pixel", ".inspector"))
    techniques = len(Select(labelled(page, "technique", ".views")).options)
    if arguments.pixel:
        x, y = arguments.pixel.split(",")
        option = next((option.text for option in menu.options if option.text.startswith(f"({x}, {y})")), None)
        check(option is not None, f"{page.width}: the pixel asked for is known")
        if option:
            menu.select_by_visible_text(option)
            check(f"{arguments.fragments} fragment" in panel(), f"{page.width}: {arguments.fragments} fragments at {x}, {y}")
    # A click goes to the known pixel that is nearest.
    left = views.find_elements(By.CSS_SELECTOR, ".pane canvas")[0]
    page.show(left)
    before = menu.first_selected_option.text
    for offset in ((-0.3, -0.3), (0.3, 0.3)):
        ActionChains(page.driver).move_to_element_with_offset(
            left, int(offset[0] * left.size["width"]), int(offset[1] * left.size["height"])).click().perform()
        nearest = page.script("""
            const views = arguments[0].views, pixels = views.inspector.index.pixels;
            const at = [(0.5 + arguments[1]) * views.data.width, (0.5 + arguments[2]) * views.data.height];
            const far = (pixel) => Math.hypot(pixel.x - at[0], pixel.y - at[1]);
            const chosen = pixels[views.inspector.at];
            return far(chosen) - Math.min(...pixels.map(far));""", views, *offset)
        check(nearest < 3, f"{page.width}: a click inspects the nearest known pixel, {nearest} farther than the nearest")
    check(menu.first_selected_option.text != before, f"{page.width}: a click inspects another pixel")
    # So do the arrow keys.
    before = menu.first_selected_option.text
    left.send_keys(Keys.ARROW_LEFT)
    check(menu.first_selected_option.text != before, f"{page.width}: arrow keys inspect another pixel")
    tables = views.find_elements(By.CSS_SELECTOR, ".inspector .columns table")
    rows = [len(table.find_elements(By.CSS_SELECTOR, "tbody tr")) for table in tables]
    check(rows[0] == techniques + 1, f"{page.width}: a colour a technique, and the reference: {rows}")
    check(rows[1] >= 1, f"{page.width}: fragments are listed")
    check(len(views.find_elements(By.CSS_SELECTOR, ".stored details")) >= 1, f"{page.width}: what is stored is listed")
    curves = page.script("""return arguments[0].views.inspector.chart.data.datasets.map((set) =>
        [set.label, set.data.map((point) => point.y)]);""", views)
    exact = curves[0][1]
    check(curves[0][0] == "exact" and len(curves) > 1, f"{page.width}: exact and techniques: {[c[0] for c in curves]}")
    check(exact[0] == 1 and all(a >= b for a, b in zip(exact, exact[1:])), f"{page.width}: exact visibility only falls")
    canvas = views.find_element(By.CSS_SELECTOR, ".inspector .chart canvas")
    switch = views.find_elements(By.CSS_SELECTOR, ".switch")[0]
    page.show(canvas)
    page.changes("a curve is switched off", canvas, switch.click)
    check(switch.get_attribute("aria-pressed") == "false", f"{page.width}: the switch says so")
    check_bars_and_cards(page, views)


def check_bars_and_cards(page, views):
    card = page.all(".card button.pair")[-1]
    page.show(card)
    menu = Select(labelled(page, "technique", ".views"))
    name = card.get_attribute("aria-label").removeprefix("show ").removesuffix(" in the viewer")
    card.click()
    check(menu.first_selected_option.text == name, f"{page.width}: a card picks its technique")
    figures = page.all("figure.bars")
    check(len(figures) == 2, f"{page.width}: bars of bytes and of cycles")
    for figure in figures:
        segment = figure.find_element(By.CSS_SELECTOR, ".bar i")
        page.show(segment)
        check(segment.size["width"] > 0 and segment.get_attribute("title"), f"{page.width}: bars have names and widths")


def check_keyboard(page):
    """Tab reaches every kind of control, and what has the focus is to be seen."""
    page.script("document.activeElement.blur(); scrollTo(0, 0)")
    reached, hidden = set(), []
    for _ in range(60):
        ActionChains(page.driver).send_keys(Keys.TAB).perform()
        kind, outline = page.script("""const at = document.activeElement;
            return [at.tagName + (at.type ? ':' + at.type : ''), getComputedStyle(at).outlineStyle];""")
        reached.add(kind)
        if outline == "none" and kind != "BODY":  # past the last one
            hidden.append(kind)
    wanted = {"compare": {"SELECT:select-one", "INPUT:checkbox", "CANVAS", "INPUT:range", "BUTTON:button", "SUMMARY"},
              "claims": {"SELECT:select-one", "INPUT:search", "BUTTON:button"},
              "bench": {"SELECT:select-one", "INPUT:checkbox", "CANVAS"},
              "validate": {"SELECT:select-one", "INPUT:search", "BUTTON:button", "CANVAS", "INPUT:range"}}[arguments.kind]
    check(wanted <= reached, f"{page.width}: Tab reaches {wanted - reached}")
    check(not hidden, f"{page.width}: the focus is visible on {set(hidden)}")


def check_table(page, choice, search, number):
    """Filter by the menu `choice` and by text, sort by the heading `number`."""
    box = page.find(".filtered")
    page.show(box)
    shown = lambda: [row for row in page.script("""return [...arguments[0].querySelectorAll('tbody tr')]
        .filter((row) => !row.hidden).map((row) => [...row.cells].map((cell) => cell.textContent))""", box)]
    everything = shown()
    headings = page.script("return [...arguments[0].querySelectorAll('thead th')].map((cell) => cell.dataset.name)", box)
    column = headings.index(choice)
    menu = Select(labelled(page, choice, ".filtered"))
    value = everything[0][column]
    menu.select_by_visible_text(value)
    check(shown() == [row for row in everything if row[column] == value] and len(shown()) < len(everything),
          f"{page.width}: the menu {choice} filters")
    menu.select_by_visible_text("all")
    field = labelled(page, "find", ".filtered")
    field.send_keys(search)
    check(shown() == [row for row in everything if search.lower() in " ".join(row).lower()] and 0 < len(shown()) < len(everything),
          f"{page.width}: text filters: {len(shown())} of {len(everything)}")
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys(Keys.DELETE)
    check(shown() == everything, f"{page.width}: all rows are back")
    place = headings.index(number)
    button = box.find_elements(By.CSS_SELECTOR, "thead th")[place].find_element(By.TAG_NAME, "button")
    values = lambda: page.script("""return [...arguments[0].querySelectorAll('tbody tr')].map((row) =>
        row.cells[arguments[1]].dataset.value).filter((value) => value !== undefined).map(Number)""", box, place)
    button.send_keys(Keys.ENTER)
    up = values()
    check(len(set(up)) > 1 and up == sorted(up), f"{page.width}: sorts by {number}: {up}")
    button.click()
    check(values() == sorted(up, reverse=True), f"{page.width}: and the other way round")


def use(page):
    check_whole_page(page)
    if arguments.kind == "compare":
        check_plot(page, "storage", "RMSE", "bytes, touched")
        views = check_viewer(page, ["reference", "technique", "bytes per tile", "depth complexity", "difference × 8"])
        if views:
            check_inspector(page, views)
    elif arguments.kind == "claims":
        check_table(page, "verdict", "bandwidth", "measured")
    elif arguments.kind == "bench":
        check_plot(page, "seconds", "error", "speed")
    else:
        check_table(page, "verdict", "adaptive", "equal")
        check_viewer(page, ["OpenGL", "model", "units apart"])
    page.shot(arguments.kind)
    check_keyboard(page)
    check_scripts_end(page)


parser = argparse.ArgumentParser()
parser.add_argument("kind", choices=["compare", "claims", "bench", "validate"])
parser.add_argument("page")
parser.add_argument("--pixel")
parser.add_argument("--fragments")
parser.add_argument("--shots")
arguments = parser.parse_args()
for size in ((1280, 900), (390, 844)):
    opened = Page(arguments.page, arguments.kind, arguments.shots, *size)
    try:
        use(opened)
        print(f"{arguments.kind} at {size[0]}: loaded in {opened.load_seconds:.2f} s")
    finally:
        opened.driver.quit()
print(f"{len(failures)} failed")
sys.exit(1 if failures else 0)
