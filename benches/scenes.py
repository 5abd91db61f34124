#!/usr/bin/env python3
"""Scenes that docs/tracer.md measures and that no demo is: degenerate ones, an interior, a room of mirrors.

  benches/scenes.py DIR [--teapot teapot.txt]

Writes DIR/NAME.txt: same_20k, any_order_20k, nested_5k, needles_100k, concentric_20k, centroid_100k, slivers_20k, one
and atrium; with --teapot, a scene file, also mirrors: its triangles in a room whose walls are plane. The same bytes each
time.
"""
import argparse
import math
import pathlib
import random

HEAD = "<s\n0 0 5\n-0.889 0.5 4\n0.889 0.5 4\n-0.889 -0.5 4\n-0.4 -0.8 -0.6\n"
BIG = ((-3, -2, 0), (3, -2, 0), (0, 3, 0))
# Looks from a corner of the room over the teapot.
IN_THE_ROOM = """<s
8.5812 5.113700000000001 6.5038
7.364638445853306 5.099040660942168 6.3432084334388525
8.125801645216523 5.099040660942168 5.364315904130783
7.553138408333609 4.443685517619431 6.489781453689372
-0.45 -1 -0.35
"""


def write(folder, name, head, triangles):
    """`triangles`: pairs of three points and a colour."""
    lines = [
        " ".join(f"{x:.7g}" for point in points for x in point) + " " + " ".join(map(str, color))
        for points, color in triangles
    ]
    (folder / f"{name}.txt").write_text(f"{head}{len(lines)}\n" + "\n".join(lines) + "\n<n\n")


def degenerate(folder):
    rng = random.Random(5)

    def color():
        return tuple(rng.randrange(40, 255) for _ in range(3))

    def scaled(size):
        return tuple((x * size, y * size, 0) for x, y, _ in BIG)

    def needle():
        angle, height = rng.uniform(0, 2 * math.pi), rng.uniform(-1, 1)
        tip = (math.cos(angle) * 3, math.sin(angle) * 2, height)
        return (0, 0, 0), tip, tuple(x + rng.uniform(-0.01, 0.01) for x in tip)

    def about_middle():
        size, angle = rng.uniform(0.01, 1), rng.uniform(0, 2 * math.pi)
        turns = [angle + k * 2 * math.pi / 3 for k in range(3)]
        return tuple((size * math.cos(a), size * math.sin(a), 0) for a in turns)

    def around_middle():
        size = rng.uniform(0.01, 1)
        p, q = ([rng.gauss(0, 1) for _ in range(3)] for _ in range(2))
        points = p, q, [-a - b for a, b in zip(p, q)]
        return tuple(tuple(size * x for x in point) for point in points)

    def sliver():
        y, z = rng.uniform(-1, 1), rng.uniform(-1, 1)
        return (-500, y, z), (500, y + rng.uniform(-0.3, 0.3), z + rng.uniform(-1, 1)), (500, y + 0.001, z)

    def any_order():
        return tuple(rng.sample(BIG, 3))

    for name, count, triangle in [
        ("same_20k", 20_000, lambda: BIG),
        ("any_order_20k", 20_000, any_order),
        ("nested_5k", 5_000, lambda: scaled(rng.uniform(0.1, 1))),
        ("needles_100k", 100_000, needle),
        ("concentric_20k", 20_000, about_middle),
        ("centroid_100k", 100_000, around_middle),
        ("slivers_20k", 20_000, sliver),
        ("one", 1, lambda: ((-300, -300, 0), (300, -300, 0), (0, 300, 0))),
    ]:
        write(folder, name, HEAD, [(triangle(), color()) for _ in range(count)])


def atrium(folder):
    """Two storeys of columns and arches with banners, plants on a floor of tiles; seen from one end."""
    rng = random.Random(7)
    triangles = []

    def quad(a, b, c, d, color):
        triangles.extend([((a, b, c), color), ((a, c, d), color)])

    def box(low, high, color):
        corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
        for face in (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3):
            quad(*(corners[i] for i in face), color)

    def lathe(x, y, z, profile, sides, color):
        def point(radius, height, side):
            angle = 2 * math.pi * side / sides
            return x + radius * math.cos(angle), y + radius * math.sin(angle), z + height

        for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
            for side in range(sides):
                lower = point(r0, z0, side), point(r0, z0, side + 1)
                upper = point(r1, z1, side + 1), point(r1, z1, side)
                if r0 > 0:
                    triangles.append(((*lower, upper[0]), color))
                if r1 > 0:
                    triangles.append(((lower[0], *upper), color))

    for i in range(-30, 30):
        for j in range(-12, 12):
            color = (150, 140, 120) if (i + j) % 2 else (90, 85, 80)
            quad((i, j, 0), (i + 1, j, 0), (i + 1, j + 1, 0), (i, j + 1, 0), color)
    for low, high in [
        ((-30.5, -12.5, -0.2), (30.5, -12, 14)),
        ((-30.5, 12, -0.2), (30.5, 12.5, 14)),
        ((-30.5, -12, -0.2), (-30, 12, 14)),
        ((30, -12, -0.2), (30.5, 12, 14)),
    ]:
        box(low, high, (170, 150, 130))
    shaft = [(0.45 - 0.1 * i / 20 + 0.015 * math.sin(i), 0.5 + 3.2 * i / 20) for i in range(1, 21)]
    column = [(0.7, 0), (0.7, 0.2), (0.6, 0.25), (0.6, 0.4), (0.45, 0.5), *shaft]
    column += [(0.5, 3.8), (0.65, 4), (0.65, 4.2), (0, 4.2)]
    for floor in 0, 5.5:
        for i in range(-27, 28, 3):
            for y in -6.5, 6.5:
                lathe(i, y, floor, column, 40, (200, 190, 170))
                if i == 27:
                    continue

                def arch(step, radius, depth):
                    angle = math.pi * step / 24
                    across = i + 1.5 - radius * math.cos(angle)
                    return across, y + depth, floor + 4.2 + radius * math.sin(angle)

                for step in range(24):
                    for depth in -0.4, 0.4:
                        inner = arch(step, 1.05, depth), arch(step + 1, 1.05, depth)
                        quad(*inner, arch(step + 1, 1.5, depth), arch(step, 1.5, depth), (180, 165, 140))
                    front = arch(step, 1.05, -0.4), arch(step + 1, 1.05, -0.4)
                    quad(*front, arch(step + 1, 1.05, 0.4), arch(step, 1.05, 0.4), (190, 175, 150))
        for low, high in (-12, -6), (6, 12):
            box((-30, low, floor + 5.3), (30, high, floor + 5.5), (140, 120, 100))
        for i in range(-9, 9):
            color = tuple(rng.randrange(60, 250) for _ in range(3))
            for y in -5.9, 5.9:

                def cloth(u, v):
                    fold = 0.15 * math.sin(6 * u / 16 + 3 * v / 32 + i)
                    return i * 3 + 1.5 + (u / 16 - 0.5) * 1.4, y + fold, floor + 5.2 - 2.6 * v / 32

                for u in range(16):
                    for v in range(32):
                        quad(cloth(u, v), cloth(u + 1, v), cloth(u + 1, v + 1), cloth(u, v + 1), color)
    for _ in range(60):
        x, y = rng.uniform(-28, 28), rng.choice((-1, 1)) * rng.uniform(1, 5)
        pot = [(0.2, 0), (0.35, 0.2), (0.4, 0.5), (0.3, 0.7), (0.35, 0.8), (0, 0.8)]
        lathe(x, y, 0, pot, 24, tuple(rng.randrange(60, 250) for _ in range(3)))
        for _ in range(250):
            angle, bend, height = rng.uniform(0, 2 * math.pi), rng.uniform(0.2, 1.2), rng.uniform(0.9, 2)
            dx, dy = math.cos(angle), math.sin(angle)
            foot = x + 0.1 * dx * bend, y + 0.1 * dy * bend
            tip = x + 0.6 * dx * bend, y + 0.6 * dy * bend, height
            sides = [(foot[0] - k * dy * 0.04, foot[1] + k * dx * 0.04, 0.8) for k in (-1, 1)]
            triangles.append(((*sides, tip), (40, rng.randrange(90, 180), 50)))
    view = "-26 -2 2.4\n-25.0799 -1.22069 2.83773\n-24.9636 -2.61627 2.83773\n-25.0452 -1.2178 2.05077\n"
    write(folder, "atrium", f"<s\n{view}-0.4 -0.5 -0.8\n", triangles)


def mirrors(folder, teapot):
    rows = [line.split() for line in teapot.read_text().splitlines()[7:] if len(line.split()) == 12]
    triangles = [
        (tuple(tuple(map(float, row[3 * k : 3 * k + 3])) for k in range(3)), tuple(map(int, row[9:]))) for row in rows
    ]
    points = [point for corners, _ in triangles for point in corners]
    low, high = ([least(p[k] for p in points) for k in range(3)] for least in (min, max))
    size = max(b - a for a, b in zip(low, high))
    low = [a - d * size for a, d in zip(low, (0.9, 0.01, 0.9))]
    high = [b + 0.9 * size for b in high]
    for axis in range(3):
        right, up = (axis + 1) % 3, (axis + 2) % 3
        for wall in low, high:
            corners = []
            for a, b in (low, low), (high, low), (high, high), (low, high):
                point = [0.0] * 3
                point[axis], point[right], point[up] = wall[axis], a[right], b[up]
                corners.append(tuple(point))
            for second in 1, 2:
                triangles.append(((corners[0], corners[second], corners[second + 1]), (200, 200, 210)))
    write(folder, "mirrors", IN_THE_ROOM, triangles)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--teapot", type=pathlib.Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    degenerate(options.folder)
    atrium(options.folder)
    if options.teapot:
        mirrors(options.folder, options.teapot)


if __name__ == "__main__":
    main()
