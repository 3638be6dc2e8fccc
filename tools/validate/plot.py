"""Small plots as SVG, without a library: a measured line or points and a theory line in a frame."""
from xml.sax.saxutils import escape

W, H, LEFT, BOTTOM, TOP, RIGHT = 300, 170, 48, 30, 8, 8
COLORS = ("#1668b0", "#c4501b", "#2b8a3e", "#7b3fa0", "#8a6d00", "#555555")


def thin(points, most=70):
    step = max(1, len(points) // most)
    return points[::step] + ([points[-1]] if (len(points) - 1) % step else [])


def limits(values):
    lo, hi = min(values), max(values)
    room = 0.05 * (hi - lo) or 0.05 * abs(hi) or 1.0
    return lo - room, hi + room


def svg(lines, theory, axes):
    """lines: [(name, [(x, y), ...])], theory: [(x, y), ...] dashed; axes: (x, y) labels."""
    everything = [p for _, points in lines for p in points] + list(theory)
    (x0, x1), (y0, y1) = limits([p[0] for p in everything]), limits([p[1] for p in everything])
    def at(p):
        return (LEFT + (p[0] - x0) / (x1 - x0) * (W - LEFT - RIGHT), H - BOTTOM - (p[1] - y0) / (y1 - y0) * (H - BOTTOM - TOP))
    def path(points, style):
        return f'<polyline fill="none" {style} points="' + " ".join("%.1f,%.1f" % at(p) for p in thin(points)) + '"/>'
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {W} {H}" width="{W}" height="{H}" font-family="sans-serif" font-size="9">',
           f'<rect width="{W}" height="{H}" fill="white"/>',
           f'<rect x="{LEFT}" y="{TOP}" width="{W - LEFT - RIGHT}" height="{H - BOTTOM - TOP}" fill="none" stroke="#999"/>']
    for value in (x0 + 0.05 * (x1 - x0), x1 - 0.05 * (x1 - x0)):
        out.append(f'<text x="{at((value, y0))[0]:.0f}" y="{H - BOTTOM + 11}" text-anchor="middle">{value:.3g}</text>')
    for value in (y0 + 0.05 * (y1 - y0), y1 - 0.05 * (y1 - y0)):
        out.append(f'<text x="{LEFT - 3}" y="{at((x0, value))[1] + 3:.0f}" text-anchor="end">{value:.3g}</text>')
    if theory:
        out.append(path(list(theory), 'stroke="#333" stroke-dasharray="4 3"'))
    for i, (name, points) in enumerate(lines):
        color = COLORS[i % len(COLORS)]
        out.append(path(points, f'stroke="{color}" stroke-width="1.2"'))
        out.append(f'<text x="{LEFT + 6}" y="{TOP + 11 + 10 * i}" fill="{color}">{escape(name)}</text>')
    out.append(f'<text x="{(LEFT + W - RIGHT) / 2}" y="{H - 4}" text-anchor="middle">{escape(axes[0])}</text>')
    out.append(f'<text x="10" y="{(TOP + H - BOTTOM) / 2}" text-anchor="middle" transform="rotate(-90 10 {(TOP + H - BOTTOM) / 2})">{escape(axes[1])}</text>')
    return "\n".join(out) + "\n</svg>\n"
