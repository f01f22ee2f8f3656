"""Draws what clicks that are off cost, before and after a change of the fit, as SVG.

    python bench/clicks.py BEFORE AFTER OUT.svg

BEFORE and AFTER are files of `bench/fit.py clicks --clicks FILE`, run with either wheel.
"""

import json
import math
import sys
from pathlib import Path

WIDTH, HEIGHT = 200, 200  # of one panel
LEFT, TOP, GAP, BELOW = 46, 34, 14, 62
LOWEST, HIGHEST = 0.8, 40.0
TICKS = (1, 2, 5, 10, 20)
SERIES = (("before", "#b5532a"), ("now", "#1f5f99"))


def x(amount, most):
    return WIDTH * amount / most


def y(times):
    times = min(max(times, LOWEST), HIGHEST)
    return HEIGHT * (1 - math.log(times / LOWEST) / math.log(HIGHEST / LOWEST))


def median(values):
    values = sorted(values)
    return (values[(len(values) - 1) // 2] + values[len(values) // 2]) / 2


def text(x, y, words, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{words}</text>'


def curve(cells, color):
    """Median as a line, the range of people as a band."""
    amounts = sorted(float(amount) for amount in cells)
    values = {float(amount): cell for amount, cell in cells.items()}

    def points(of, order):
        return " ".join(f"{x(a, amounts[-1]):.1f},{y(of(values[a])):.1f}" for a in order)

    band = points(max, amounts) + " " + points(min, amounts[::-1])
    return (
        f'<polygon points="{band}" fill="{color}" fill-opacity="0.16"/>'
        f'<polyline points="{points(median, amounts)}" fill="none" stroke="{color}" stroke-width="2"/>'
    )


def panel(number, runs, count):
    amounts = sorted(float(amount) for amount in runs[0][count])
    out = [f'<g transform="translate({LEFT + number * (WIDTH + GAP)} {TOP})">']
    for tick in TICKS:
        out.append(f'<path d="M0 {y(tick):.1f}H{WIDTH}" stroke="#d8d8d8"/>')
        if number == 0:
            out.append(text(-6, y(tick) + 4, str(tick), "end"))
    told = amounts[:1] + amounts[2:]  # no room beside 0
    out += [text(x(amount, amounts[-1]), HEIGHT + 16, f"{100 * amount:g}") for amount in told]
    out += [curve(run[count], color) for run, (_, color) in zip(runs, SERIES, strict=True)]
    out.append(f'<path d="M0 0V{HEIGHT}H{WIDTH}" fill="none" stroke="#666"/>')
    out.append(text(WIDTH / 2, -10, f"{count} markers", extra=' font-weight="bold"'))
    return "".join(out) + "</g>"


def main():
    *files, out = sys.argv[1:]
    runs = [json.loads(Path(file).read_text()) for file in files]
    counts = list(runs[0])
    width = LEFT + len(counts) * (WIDTH + GAP)
    height = TOP + HEIGHT + BELOW
    parts = [panel(number, runs, count) for number, count in enumerate(counts)]
    parts.append(text(width / 2, TOP + HEIGHT + 36, "clicks off by, in percent of the diagonal"))
    for number, (name, color) in enumerate(SERIES):
        at = LEFT + number * 90
        parts.append(f'<path d="M{at} {height - 30}h22" stroke="{color}" stroke-width="3"/>')
        parts.append(text(at + 28, height - 26, name, "start"))
    label = f' transform="rotate(-90 12 {TOP + HEIGHT / 2})"'
    parts.append(text(12, TOP + HEIGHT / 2, "error over the best", extra=label))
    Path(out).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="12" fill="#222">'
        f'<rect width="{width}" height="{height}" fill="#fff"/>' + "".join(parts) + "</svg>\n"
    )


if __name__ == "__main__":
    main()
