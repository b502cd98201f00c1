"""Draws the hardware pages' pictures: wiring of GM6020 motors and of STS servos, and the parts of the driver."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from spiraltrunk.files.atomic import write_text

IMAGES = Path(__file__).parents[1] / "images"
POWER, DATA, INK, FILL = "#b3261e", "#1b5e7d", "#333333", "#f4f6f8"
DASH = 'stroke-dasharray="7 5"'

Box = tuple[float, float, float, float]
"""Left, top, width and height."""


class Drawing:
    """Boxes, lines and words on white, which is readable on light and on dark pages."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.size, self.title = (width, height), title
        self.items: list[str] = []

    def box(self, at: Box, *lines: str, color: str = INK) -> None:
        """A box with its words in the middle."""
        x, y, w, h = at
        self.items.append(
            f'<rect x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}" rx="6" fill="{FILL}" stroke="{color}" '
            'stroke-width="1.6"/>'
        )
        top = y + h / 2 + 5 - 9.5 * (len(lines) - 1)
        for i, line in enumerate(lines):
            self.text(x + w / 2, top + 19 * i, line, anchor="middle", is_bold=i == 0)

    def text(
        self, x: float, y: float, words: str, *, anchor: str = "start", color: str = INK, is_bold: bool = False
    ) -> None:
        """Words at a point."""
        weight = ' font-weight="600"' * is_bold
        self.items.append(
            f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{color}"{weight}>{escape(words)}</text>'
        )

    def line(
        self, points: Sequence[tuple[float, float]], color: str, *, is_dashed: bool = False, ends: str = ""
    ) -> None:
        """A line through points; ``ends`` has "a" for an arrow at its end and "b" for one at its start."""
        way = " ".join(f"{x:g},{y:g}" for x, y in points)
        name = {POWER: "power", DATA: "data", INK: "ink"}[color]
        marks = (f' marker-end="url(#{name})"' * ("a" in ends)) + (f' marker-start="url(#{name})"' * ("b" in ends))
        dash = f" {DASH}" * is_dashed
        self.items.append(f'<polyline points="{way}" fill="none" stroke="{color}" stroke-width="2"{dash}{marks}/>')

    def dot(self, x: float, y: float, color: str) -> None:
        """Where lines are joined."""
        self.items.append(f'<circle cx="{x:g}" cy="{y:g}" r="4" fill="{color}"/>')

    def build(self) -> str:
        """The picture as SVG."""
        w, h = self.size
        marker = (
            '<marker id="{0}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
            'orient="auto-start-reverse"><path d="M0,0 L10,5 L0,10 z" fill="{1}"/></marker>'
        )
        marks = "".join(marker.format(name, color) for name, color in (("power", POWER), ("data", DATA), ("ink", INK)))
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w} {h}" width="{w}" height="{h}" role="img" '
            f'font-family="Helvetica, Arial, sans-serif" font-size="13.5"><title>{escape(self.title)}</title>'
            f'<defs>{marks}</defs><rect width="{w}" height="{h}" fill="#ffffff"/>'
        )
        return "\n".join([head, *self.items, "</svg>", ""])


def draw_power(drawing: Drawing, supply: str, fuses: tuple[str, ...]) -> None:
    """Supply, main fuse and relay above; emergency stop, timer's contact and the relay's coil below them."""
    drawing.box((30, 40, 140, 54), *supply.split("|"), color=POWER)
    drawing.box((240, 40, 130, 54), "main fuse", color=POWER)
    drawing.box((590, 40, 140, 54), "main relay", "contacts 1 and 2", color=POWER)
    drawing.box((800, 40, 150, 54), *fuses, color=POWER)
    drawing.line([(170, 67), (240, 67)], POWER)
    drawing.line([(370, 67), (590, 67)], POWER)
    drawing.line([(730, 67), (800, 67)], POWER)
    drawing.dot(410, 67, POWER)
    drawing.box((240, 190, 140, 56), "emergency stop", "normally closed", color=POWER)
    drawing.box((425, 190, 130, 56), "timer's contact", "and start button", color=POWER)
    drawing.box((600, 190, 120, 56), "relay's coil", "with diode", color=POWER)
    drawing.line([(410, 67), (410, 140), (310, 140), (310, 190)], POWER)
    drawing.line([(380, 218), (425, 218)], POWER)
    drawing.line([(555, 218), (600, 218)], POWER)
    drawing.line([(720, 218), (765, 218)], POWER)
    drawing.text(773, 223, "minus", color=POWER)
    drawing.line([(660, 190), (660, 94)], INK, is_dashed=True)


def draw_watchdog(drawing: Drawing) -> None:
    """Computer, the timer that it feeds, and the contact that tells it whether the relay is closed."""
    drawing.box((30, 190, 140, 56), "timer", "retriggerable", color=DATA)
    drawing.box((30, 340, 140, 60), "computer", color=DATA)
    drawing.line([(65, 340), (65, 246)], DATA, ends="a")
    drawing.text(58, 300, "TX", anchor="end", color=DATA)
    drawing.line([(700, 94), (700, 120), (190, 120), (190, 300), (130, 300), (130, 340)], DATA, ends="a")
    drawing.text(138, 325, "CTS", color=DATA)
    drawing.text(645, 113, "contact 2: is the relay closed?", anchor="end", color=DATA)
    drawing.line([(170, 232), (205, 232), (205, 275), (490, 275), (490, 246)], INK, is_dashed=True)


def draw_gm6020() -> Drawing:
    """Three GM6020 on an adapter, with the timer as watchdog."""
    drawing = Drawing(980, 590, "Wiring of three GM6020 motors with a USB-CAN adapter, a relay and an emergency stop")
    draw_power(drawing, "supply|24 V", ("fuse per motor", "and capacitor"))
    draw_watchdog(drawing)
    drawing.line([(875, 94), (875, 305)], POWER)
    drawing.line([(555, 305), (875, 305)], POWER)
    for number, x in enumerate((490, 650, 810), start=1):
        drawing.box((x, 340, 130, 60), f"motor {number}", f"id {number}")
        drawing.line([(x + 65, 305), (x + 65, 340)], POWER, ends="a")
        if number < 3:
            drawing.line([(x + 130, 370), (x + 160, 370)], DATA)
    drawing.dot(715, 305, POWER)
    drawing.dot(875, 305, POWER)
    drawing.box((270, 340, 150, 60), "USB-CAN adapter", "120 ohm", color=DATA)
    drawing.line([(170, 370), (270, 370)], DATA)
    drawing.text(178, 388, "USB", color=DATA)
    drawing.line([(420, 370), (490, 370)], DATA)
    drawing.text(432, 388, "CAN", color=DATA)
    drawing.text(875, 420, "120 ohm at the last", anchor="middle", color=DATA)
    drawing.dot(310, 140, POWER)
    drawing.line([(310, 140), (225, 140), (225, 475), (270, 475)], POWER, ends="a")
    drawing.box((270, 448, 150, 54), "converter to 5 V", "own fuse", color=POWER)
    drawing.box((490, 448, 150, 54), "servo driver", "50 Hz", color=DATA)
    drawing.box((710, 448, 150, 54), "gripper's servo")
    drawing.line([(420, 475), (490, 475)], POWER, ends="a")
    drawing.line([(640, 475), (710, 475)], DATA, ends="a")
    draw_legend(drawing, 550, "red: 24 V plus")
    return drawing


def draw_sts() -> Drawing:
    """Three STS servos on a bus adapter."""
    drawing = Drawing(980, 500, "Wiring of three STS bus servos with a serial adapter, a relay and an emergency stop")
    draw_power(drawing, "supply|12 V or 7.4 V", ("capacitor",))
    draw_watchdog(drawing)
    drawing.line([(875, 94), (875, 305), (345, 305), (345, 340)], POWER, ends="a")
    drawing.box((270, 340, 150, 60), "servo bus adapter", "1 Mbit/s", color=DATA)
    drawing.line([(170, 370), (270, 370)], DATA)
    drawing.text(178, 388, "USB", color=DATA)
    for number, x in enumerate((490, 650, 810), start=1):
        drawing.box((x, 340, 130, 60), f"servo {number}", f"id {number}")
        drawing.line([(x - 30 if number > 1 else 420, 363), (x, 363)], POWER)
        drawing.line([(x - 30 if number > 1 else 420, 377), (x, 377)], DATA)
    drawing.text(680, 424, "plus, minus and one data wire from servo to servo", anchor="middle")
    draw_legend(drawing, 465, "red: supply plus")
    return drawing


def draw_legend(drawing: Drawing, y: float, power: str) -> None:
    """What the colours mean."""
    words = "minus is common to all and not drawn"
    drawing.text(30, y, power, color=POWER)
    drawing.text(165, y, "blue: data", color=DATA)
    drawing.text(265, y, f"dashed: what moves a contact; {words}")


def draw_parts() -> Drawing:
    """What stands between a strategy and a motor."""
    drawing = Drawing(980, 470, "A strategy, the plant, the driver and its ports, and what is behind each port")
    drawing.box((30, 30, 170, 60), "strategy", "or jog, pull, run")
    drawing.box((30, 190, 170, 60), "HardwarePlant", "50 Hz")
    drawing.line([(95, 90), (95, 190)], INK, ends="a")
    drawing.line([(150, 190), (150, 90)], INK, ends="a")
    drawing.text(87, 145, "command", anchor="end")
    drawing.text(158, 145, "observation")
    drawing.items.append(
        f'<rect x="290" y="30" width="330" height="380" rx="8" fill="#ffffff" stroke="{DATA}" stroke-width="2"/>'
    )
    drawing.text(455, 56, "TrunkDriver: one tick a period", anchor="middle", color=DATA, is_bold=True)
    steps = (
        ("read", "latest feedback of motors and arm"), ("refuse", "targets that are not sound"),
        ("winders", "tension and length to torque"), ("watches", "is anything wrong?"),
        ("states", "safe, homing, armed, fault"), ("send", "torques or ramp; feed the watchdog"),
    )  # fmt: skip
    for i, lines in enumerate(steps):
        drawing.box((310, 70 + 55 * i, 290, 46), *lines)
    drawing.line([(200, 220), (290, 220)], DATA, ends="ab")
    drawing.text(245, 208, "targets", anchor="middle", color=DATA)
    ports = (
        ("MotorPort", "GM6020 on CAN or board;", "STS on a serial line"), ("Watchdog", "board or relay", ""),
        ("ServoPort", "pulses by the board", ""), ("ArmPort", "MuJoCo, panda-python,", "franky"),
    )  # fmt: skip
    for i, (name, first, second) in enumerate(ports):
        y = 30 + 98 * i
        drawing.box((700, y, 250, 78), name, *(line for line in (first, second) if line), color=DATA)
        drawing.line([(620, y + 39), (700, y + 39)], DATA, ends="ab")
    drawing.box((30, 340, 170, 60), "log", "MCAP file")
    drawing.line([(290, 370), (200, 370)], INK, ends="a")
    words = "Each port has a twin at its other end: it speaks the same bytes, fails on request, and pulls on the trunk."
    drawing.text(30, 448, words)
    return drawing


def main() -> None:
    """Write the pictures."""
    for name, build in (("wiring_gm6020", draw_gm6020), ("wiring_sts", draw_sts), ("hardware_parts", draw_parts)):
        write_text(IMAGES / f"{name}.svg", build().build())


if __name__ == "__main__":
    main()
