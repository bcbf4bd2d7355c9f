"""How a robot walks: joint angles (radians, about X unless said) as functions of its stride's
phase.

Feet stand still on the ground while they carry; the legs follow by two-bone inverse kinematics in
the walking plane.
"""

import math
from collections.abc import Callable

from robot_parts import ANKLE_HEIGHT, SHIN, THIGH

STRIDE, PERIOD = 1.05, 20.0  # metres and frames from a step of the left foot to its next
_CARRYING = 0.62  # share of the stride a foot is on the ground
_HIP_BELOW_ROOT = 0.05

Pose = dict[tuple[str, int], float]  # (part, axis) to angle
Gesture = Callable[[float, float], Pose]


def hips_height(phase: float) -> float:
    """The body is lowest when both feet carry."""
    return (
        ANKLE_HEIGHT
        + THIGH
        + SHIN
        + _HIP_BELOW_ROOT
        - 0.055
        - 0.022 * math.cos(4 * math.pi * phase)
    )


def foot(phase: float) -> tuple[float, float, float]:
    """A foot's ankle ahead of the hips (m), its height over the ground (m), and its pitch."""
    phase %= 1.0
    reach = STRIDE * _CARRYING
    if phase < _CARRYING:
        late = max(0.0, phase / _CARRYING - 0.8) / 0.2
        return reach * (0.5 - phase / _CARRYING), ANKLE_HEIGHT + 0.05 * late**2, -0.4 * late**2
    swing = (phase - _CARRYING) / (1 - _CARRYING)
    ease = (1 - math.cos(math.pi * swing)) / 2
    lift = 0.05 * (1 - swing) ** 2 + 0.13 * math.sin(math.pi * swing)
    return (
        reach * (ease - 0.5),
        ANKLE_HEIGHT + lift,
        -0.4 * (1 - swing) ** 2 + 0.25 * math.sin(math.pi * swing),
    )


def leg(side: str, phase: float) -> Pose:
    """Thigh, knee, ankle and toe of one leg."""
    ahead, height, pitch = foot(phase)
    drop = hips_height(phase) - _HIP_BELOW_ROOT - height
    span = min(math.hypot(ahead, drop), (THIGH + SHIN) * 0.9995)
    line = math.atan2(ahead, drop)
    thigh = line + math.acos((THIGH**2 + span**2 - SHIN**2) / (2 * THIGH * span))
    shin = line - math.acos((SHIN**2 + span**2 - THIGH**2) / (2 * SHIN * span))
    bend = {
        "Thigh": thigh,
        "Knee": (shin - thigh) / 2,
        "Shin": (shin - thigh) / 2,
        "Ankle": pitch - shin,
    }
    bend["Toe"] = max(0.0, -pitch) if phase % 1.0 < _CARRYING else 0.0
    return {(f"{part}.{side}", 0): angle for part, angle in bend.items()}


def body(phase: float) -> Pose:
    """Sway of trunk and head; antennae lag behind."""
    turn = 2 * math.pi * phase
    pose = {
        ("Waist", 2): 0.09 * math.sin(turn),
        ("Chest", 1): 0.035 * math.sin(turn),
        ("Chest", 0): -0.05,
        ("Neck", 2): -0.07 * math.sin(turn),
        ("Head", 0): 0.04 * math.cos(2 * turn),
        ("Dial", 1): turn,
    }
    for side in "LR":
        pose[f"Antenna.{side}", 0] = 0.16 * math.sin(2 * turn - 1.0)
    return pose


def swinging(side: str) -> Gesture:
    """An arm swinging against the leg of its side."""

    def pose(phase: float, _: float) -> Pose:
        swing = math.cos(2 * math.pi * (phase + (0.5 if side == "L" else 0.0)))
        angles = {"Shoulder": 0.42 * swing, "Elbow": 0.35 + 0.2 * swing, "Hand": 0.1 * swing}
        return {(f"{part}.{side}", 0): angle for part, angle in angles.items()} | closed(side, 0.5)

    return pose


def waving(side: str) -> Gesture:
    """An arm raised to the side, waving."""

    def pose(_: float, frame: float) -> Pose:
        out = -1.0 if side == "L" else 1.0
        wave = math.sin(2 * math.pi * frame / 10)
        angles = {
            (f"Shoulder.{side}", 1): -out * 1.9,
            (f"Elbow.{side}", 1): -out * (0.75 + 0.35 * wave),
            (f"Hand.{side}", 1): -out * 0.3 * math.sin(2 * math.pi * frame / 10 - 0.8),
        }
        return angles | closed(side, 0.05)

    return pose


def carrying(side: str) -> Gesture:
    """An arm held out in front under a load."""

    def pose(phase: float, _: float) -> Pose:
        give = 0.03 * math.cos(4 * math.pi * phase)
        inward = 0.12 if side == "L" else -0.12
        angles = {
            (f"Shoulder.{side}", 0): 0.55 + give,
            (f"Elbow.{side}", 0): 0.98 - give,
            (f"Wrist.{side}", 2): inward,
        }
        return angles | closed(side, 0.1)

    return pose


def closed(side: str, amount: float) -> Pose:
    """Fingers bent by so much at each joint."""
    pose: Pose = {}
    for finger, sign in (("Thumb", 1.0), ("Index", -1.0), ("Little", 1.0)):
        pose[f"{finger}.{side}", 0] = sign * amount
    return pose
