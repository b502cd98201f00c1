"""How long strategies think, and how late the driver's loop is in real time on this computer.

A strategy thinks in `init` (its plan) and `step`; on a robot its thread is not the loop's, and its command is too old
40 ms after the one before, or `plant.THINKING` after it while the robot holds still (`sweep` plans its grasp there).
Processor time is told beside wall time, which other programs lengthen. Lateness is measured on the twin in real time
while another thread computes in Python, for two switch intervals of the interpreter.

``python benchmarks/drive_real_time.py kick sweep`` runs these strategies on the twin in real time instead: the computer
must be idle, for the simulation of the scene shares the interpreter with the driver's loop.
"""

from __future__ import annotations

import sys
import threading
import time

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.hardware.driver import threaded_driver
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.drive.trial import run_on_twin
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot
from spiraltrunk.workflows.grasp.world import draw_scene

INTERVALS = (0.005, threaded_driver.SWITCH_INTERVAL)


def time_strategy(name: str) -> None:
    """Print how long the steps of one trial took."""
    strategy, times = strategies.get(name), []
    shape = DEFAULT_OBJECT if DEFAULT_OBJECT in strategy.objects else strategy.objects[0]
    plant = SimPlant(presets.PAPER, draw_scene(parse_object(shape), 0, strategy=strategy))
    think = strategy.step

    def step(state, observation):
        wall, processor = time.perf_counter(), time.thread_time()
        result = think(state, observation)
        times.append((time.perf_counter() - wall, time.thread_time() - processor))
        return result

    strategy.step = step
    planning = run(plant, strategy).planning
    wall, processor = 1e3 * np.array(times).T
    cpu, clock = [f"{np.percentile(part, 99):6.2f} {part.max():7.1f}" for part in (processor, wall)]
    print(f"{name:17s} {len(times):5d} steps; plan {planning:5.2f} s; p99, max [ms]: processor {cpu}, wall {clock}")


def time_loop(interval: float) -> None:
    """Print how late the loop was while another thread computed."""
    threaded_driver.SWITCH_INTERVAL, is_over = interval, threading.Event()

    def compute() -> None:
        while not is_over.is_set():
            sum(range(1000))

    with TwinRobot(presets.PAPER, options=TwinOptions(is_real_time=True)) as robot:
        thread = threading.Thread(target=compute)
        thread.start()
        try:
            robot.prepare()
            robot.pull_to([0.02, -0.005, -0.005], tension=20.0, hold=3.0)
            end = "held"
        except SpiralTrunkError as error:
            end = str(error)
        finally:
            is_over.set()
            thread.join()
        late = robot.driver.snapshot().lateness
    figures = ", ".join(f"{1e3 * part:.2f}" for part in (late.p50, late.p99, late.p999))
    print(f"switch interval {1e3 * interval:g} ms: late by {figures} ms (p50, p99, p99.9); {end}")


def run_strategy(name: str) -> None:
    """Print how a run on the twin in real time ended."""
    shape = parse_object(strategies.get(name).objects[0])
    try:
        done = run_on_twin(presets.PAPER, shape, strategy=name, options=TwinOptions(is_real_time=True))
    except SpiralTrunkError as error:
        print(f"{name}: {error}")
        return
    log, late = done.trial.log, done.snapshot.lateness
    figures = ", ".join(f"{1e3 * part:.2f}" for part in (late.p50, late.p99, late.p999))
    faults = "; ".join(fault.text for fault in done.snapshot.faults) or "none"
    print(f"{name}: {len(log.commands)} commands, faults: {faults}; {done.trial.verdict.reason}; late by {figures} ms")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        run_strategy(name)
    if sys.argv[1:]:
        sys.exit()
    for interval in INTERVALS:
        time_loop(interval)
    for name in strategies.NAMES:
        time_strategy(name)
