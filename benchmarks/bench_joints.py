"""Static loads of single joints: stiffness with its interval, where the beam law fails, and a picture of it all.

`python benchmarks/bench_joints.py FILE [--plot FILE]`; the record has the columns joint,lever_arm_m,mass_g,angle_deg.
"""

from __future__ import annotations

import argparse
import math
import sys

import numpy as np

from spiraltrunk.calibration.joint_bench_csv import load_static_loads
from spiraltrunk.calibration.joint_bench_fit import fit_static
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.report import format_table
from spiraltrunk.report.joint_bench_plot import LoadedJoint, build_loads_figure
from spiraltrunk.report.style import write_figure


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("record")
    parser.add_argument("--plot")
    arguments = parser.parse_args()
    rows, drawn = [], []
    try:
        for loads in load_static_loads(arguments.record):
            fit = fit_static(loads.bend, loads.mass, loads.lever_arm)
            k, moment = fit.stiffness, GRAVITY * loads.mass * loads.lever_arm
            secant = moment[loads.bend > 0] / loads.bend[loads.bend > 0]
            begin = fit.faces_from
            at = "-" if math.isnan(begin.value) else " ".join(f"{math.degrees(a):.1f}" for a in (begin.low, begin.high))
            errors = f"{1e3 * fit.beam_error:.1f}, {1e3 * fit.error:.1f}"
            rows.append(
                (str(loads.joint), f"{fit.beam.value:.3f}", f"{k.value:.3f} ({k.low:.3f} to {k.high:.3f})",
                 f"{fit.onset.value:.4f}", f"{fit.faces.value:.2f}", at, errors,
                 f"{secant[0]:.3f}, {secant.min():.3f}")
            )  # fmt: skip
            drawn.append(
                LoadedJoint(name=f"joint {loads.joint}", bend=loads.bend, moment=np.asarray(moment),
                            beam=fit.beam.value, law=fit.moment, faces_from=fit.faces_from.value)
            )  # fmt: skip
    except SpiralTrunkError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    header = (
        "joint",
        "beam law",
        "K with terms, 95 %",
        "onset N m",
        "faces",
        "from deg, 95 %",
        "left mN m",
        "secant first, least",
    )
    print(format_table(rows, header=header, title="Stiffness in N m/rad"))
    if arguments.plot is not None:
        write_figure(build_loads_figure(drawn), arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
