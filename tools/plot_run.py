#!/usr/bin/env python3
"""Draws what `brim plot` has read of a run: time per phase, energies, overlap and contacts, iterations.

  plot_run.py DATA.json OUT.svg|OUT.png

The first panel is figure 6 of the paper: bodies and solver above, collision detection and modelling below. Exit codes: 0;
1 with a line on stderr; 3 where this Python has no Matplotlib.
"""

import json
import os
import sys

# (phase, label, colour), from the bottom up; what is above "solve" is no contact, as in the paper's figure.
DETECTION = [("presence", "presence", "#08306b"), ("refine", "refine", "#2171b5"), ("rasterize", "rasterize", "#6baed6"),
             ("detect", "detect", "#c6dbef")]
RESPONSE = [("respond", "respond", "#fd8d3c"), ("solve_contact", "contact in the solve", "#fdd0a2")]
REST = [("bodies", "bodies in the solve", "#e5e5e5"), ("advance", "advance", "#f2f2f2"), ("other", "other", "#fafafa")]
PAPER_SHARE = 0.25  # "less than 25% of the computation time" (section 7)


def phases(data):
    """Seconds per phase and frame, adding up to the time in steps; the solver's own share is apart from contact's."""
    seconds = {name: list(values) for name, values in data["seconds"].items()}
    seconds["bodies"] = [max(0.0, a - b) for a, b in zip(seconds["solve"], seconds["solve_contact"])]
    known = [name for name, *_ in DETECTION + RESPONSE + REST if name in seconds]
    wall = data["series"]["wall"]
    seconds["other"] = [max(0.0, w - sum(seconds[k][i] for k in known)) for i, w in enumerate(wall)]
    return seconds


def shares(seconds, wall):
    """Of the time in steps: collision detection and modelling; all of contact, its part of the solve included."""
    total = sum(wall) or 1.0
    detection = sum(sum(seconds[name]) for name, *_ in DETECTION)
    return detection / total, (detection + sum(sum(seconds[name]) for name, *_ in RESPONSE)) / total


def draw(data, out):
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams.update({"font.size": 8, "svg.hashsalt": "brim", "svg.fonttype": "none", "axes.spines.top": False,
                                "axes.spines.right": False, "legend.frameon": False})
    import matplotlib.pyplot as plt

    time, series, seconds = data["time"], data["series"], phases(data)
    detection, contact = shares(seconds, series["wall"])
    figure, (above, energy, overlap, work) = plt.subplots(
        4, 1, sharex=True, figsize=(7.2, 8.4), gridspec_kw={"height_ratios": [2.2, 1, 1, 1]}, layout="constrained")
    layers = DETECTION + RESPONSE + REST
    above.stackplot(time, [seconds[name] for name, *_ in layers], labels=[label for _, label, _ in layers],
                    colors=[colour for *_, colour in layers], step="mid", linewidth=0)
    above.step(time, series["wall"], where="mid", color="black", linewidth=0.6)
    above.step(time, [PAPER_SHARE * w for w in series["wall"]], where="mid", color="black", linewidth=0.6, linestyle=":",
               label="a quarter of the step")
    above.set_ylabel("time of a frame [s]")
    above.set_title(f"{data['scene']}: detection and modelling {detection:.0%} of the time in steps, with the response and "
                    f"its part of the solve {contact:.0%}", fontsize=8, loc="left")
    handles, labels = above.get_legend_handles_labels()
    above.legend(handles[::-1], labels[::-1], loc="upper left", bbox_to_anchor=(1.0, 1.0))

    parts = [("kinetic", "#1668b0"), ("potential", "#2b8a3e"), ("contact", "#c4501b")]
    base = series["potential_energy"][-1]
    for name, colour in parts:
        shift = base if name == "potential" else 0.0
        energy.plot(time, [e - shift for e in series[f"{name}_energy"]], color=colour, linewidth=1, label=name)
    energy.plot(time, [sum(series[f"{name}_energy"][i] for name, _ in parts) - base for i in range(len(time))],
                color="black", linewidth=0.8, linestyle="--", label="sum")
    energy.set_ylabel("energy [J]")
    energy.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title="potential: 0 at the end", title_fontsize=7)

    overlap.plot(time, series["worst_overlap"], color="#c4501b", linewidth=1)
    overlap.set_ylabel("worst overlap [voxels]", color="#c4501b")
    overlap.set_ylim(bottom=0)
    count = overlap.twinx()
    count.spines["right"].set_visible(True)
    count.plot(time, series["contacts"], color="#555555", linewidth=0.8)
    count.set_ylabel("contact nodes", color="#555555")
    count.set_ylim(bottom=0)

    work.plot(time, series["cg_iterations"], color="#1668b0", linewidth=1, label="conjugate gradients")
    if any(series["sweeps"]):
        work.plot(time, series["sweeps"], color="#7b3fa0", linewidth=1, label="sweeps over rows")
    work.plot(time, series["substeps"], color="#2b8a3e", linewidth=0.8, label="sub-steps")
    work.set_yscale("symlog", linthresh=10)
    work.set_ylim(bottom=0)
    work.set_ylabel("iterations of a frame")
    work.set_xlabel("simulated time [s]")
    work.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    part = out + ".part" + os.path.splitext(out)[1]
    metadata = {"Date": None} if out.endswith(".svg") else {"Software": "brim"}
    try:
        figure.savefig(part, dpi=100, metadata=metadata)
        os.replace(part, out)
    finally:
        if os.path.exists(part):
            os.remove(part)


def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return 3
    with open(arguments[0], encoding="utf-8") as file:
        data = json.load(file)
    try:
        draw(data, arguments[1])
    except OSError as error:
        print(f"brim: error: {arguments[1]}: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
