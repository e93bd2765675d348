# SPDX-License-Identifier: MIT
"""Shaded pictures of triangles as PNG, by the standard library alone: for paper_tables.py."""
import math
import struct
import zlib

WHITE = (255, 255, 255)
OVERSAMPLING = 2  # samples a pixel along each axis


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length) if length else (0.0, 0.0, 0.0)


class View:
    """An orthographic camera that looks against `towards`, +y up, and a light from `light`."""

    def __init__(self, towards, light):
        self.out = unit(towards)
        self.right = unit(cross((0, 1, 0), self.out))
        self.up = cross(self.out, self.right)
        self.light = unit(light)

    def seen(self, points):
        """The points as (right, up, out)."""
        return [(dot(p, self.right), dot(p, self.up), dot(p, self.out)) for p in points]


def frame_of(seen, margin):
    """(left, bottom, right, top) around the points with `margin` as a share of the larger side."""
    low, high = ([f(p[k] for p in seen) for k in (0, 1)] for f in (min, max))
    gap = margin * max(high[0] - low[0], high[1] - low[1])
    return (low[0] - gap, low[1] - gap, high[0] + gap, high[1] + gap)


def picture(view, points, faces, frame, height, edges):
    """The PNG of `frame` with `height` rows of pixels: every triangle in one shade, nearest first, with its
    edges where `edges`, so that what its normal does is seen and nothing is smoothed over."""
    scale = OVERSAMPLING * height / (frame[3] - frame[1])
    width = max(1, round((frame[2] - frame[0]) * scale / OVERSAMPLING))
    columns, rows = width * OVERSAMPLING, height * OVERSAMPLING
    colours, depth = [WHITE] * (columns * rows), [-math.inf] * (columns * rows)
    at = [((x - frame[0]) * scale, (frame[3] - y) * scale, z * scale) for x, y, z in view.seen(points)]
    for face in faces:
        a, b, c = (at[v] for v in face)
        twice_area = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
        if twice_area <= 1e-12:  # turned away, or seen from the side
            continue
        corners = [points[v] for v in face]
        normal = unit(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])))
        light = 0.2 + 0.8 * max(0.0, dot(normal, view.light))
        shade = (round(235 * light), round(226 * light), round(205 * light))
        line = tuple(round(0.35 * channel) for channel in shade)
        # The share of each corner is linear over the plane: at (x, y) share = s0 + sx x + sy y. Times the
        # corner's height over the opposite side it is the distance to that side in samples.
        shares = []
        for p, q in ((b, c), (c, a), (a, b)):
            sx, sy = (q[1] - p[1]) / twice_area, (p[0] - q[0]) / twice_area
            s0 = -(sx * p[0] + sy * p[1])
            shares.append((s0, sx, sy, 0.6 * math.hypot(sx, sy) if edges else -math.inf))
        z0, zx, zy = (sum(share[k] * corner[2] for share, corner in zip(shares, (a, b, c))) for k in range(3))
        (_, ux, _, thin_u), (_, vx, _, thin_v), (_, wx, _, thin_w) = shares
        for y in range(max(0, math.ceil(min(a[1], b[1], c[1]) - 0.5)),
                       min(rows - 1, math.floor(max(a[1], b[1], c[1]) - 0.5)) + 1):
            low, high = 0.0, float(columns)
            for s0, sx, sy, _ in shares:
                start = s0 + sy * (y + 0.5)
                if sx > 0:
                    low = max(low, -start / sx)
                elif sx < 0:
                    high = min(high, -start / sx)
                elif start < 0:
                    high = -1.0
            first, last = max(0, math.ceil(low - 0.5)), min(columns - 1, math.floor(high - 0.5))
            if first > last:
                continue
            z = z0 + zx * (first + 0.5) + zy * (y + 0.5)
            u, v, w = (s0 + sx * (first + 0.5) + sy * (y + 0.5) for s0, sx, sy, _ in shares)
            for i in range(y * columns + first, y * columns + last + 1):
                if z > depth[i]:
                    depth[i] = z
                    colours[i] = line if u < thin_u or v < thin_v or w < thin_w else shade
                z, u, v, w = z + zx, u + ux, v + vx, w + wx
    return png(width, height, colours)


def png(width, height, colours):
    """`colours` has OVERSAMPLING x OVERSAMPLING samples a pixel, row by row."""
    n, columns = OVERSAMPLING, width * OVERSAMPLING
    data, blends = bytearray(), {}
    for y in range(height):
        data.append(0)  # the row is not filtered
        rows = [colours[(y * n + j) * columns:(y * n + j + 1) * columns] for j in range(n)]
        for samples in zip(*(row[i::n] for row in rows for i in range(n))):
            if samples not in blends:  # most pixels are of few kinds
                blends[samples] = bytes(sum(channel) // (n * n) for channel in zip(*samples))
            data += blends[samples]

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(data), 9))
            + chunk(b"IEND", b""))
