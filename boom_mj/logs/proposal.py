"""A topic map proposed from what is in a log; what is only a guess carries a question mark and is not accepted."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from boom_mj.logs.checks import DRIVING
from boom_mj.logs.encodings.row import ALL
from boom_mj.logs.inspection import TIME, LogSummary, Range, Topic
from boom_mj.logs.topic_map import FIELDS
from boom_mj.logs.topics import TOPIC_NAMED
from boom_mj.logs.units import GUESS, UNITS, guess_unit
from boom_mj.recording import QUANTITIES

COMMANDED = re.compile(r"command|cmd|reference|desired|setpoint|target|goal|(^|[/_.])(ref|des|soll)([/_.\d]|$)", re.I)
JOINT = re.compile(
    r"(?:joint|axis|angle|theta|phi|q|link|boom|arm|achse|gelenk)[_/. ]*(?:angle|pos)?[_/. ]*([1-5])(?!\d)", re.I
)
CYLINDER = re.compile(r"(?:cylinder|cyl|zyl)[a-z]*[_/. ]*([23])(?!\d)", re.I)
LINK = re.compile(r"link[_/. ]*([2-5])(?!\d)", re.I)
RATE, FORCE = re.compile(r"gyro|rate|omega|angular|vel", re.I), re.compile(r"force|effort|kraft", re.I)
ACCELERATION = re.compile(r"acc|specific_force", re.I)
AXIS = re.compile(r"(?:^|[_/.])([xyz])(?:[_/.]|$)|([xyz])$", re.I)
SI = re.compile(r"^(sensor_msgs|geometry_msgs|control_msgs|trajectory_msgs|foxglove)\b")  # types that prescribe units
SLEW = re.compile(r"slew|swing|yaw|turret|dreh|rotat", re.I)


@dataclass(frozen=True)
class Proposal:
    """One entry, or what may become one.

    Attributes:
        pairs: channel of the signal -> name in the log; empty for all, in order.
        ranges: of those names.
        remark: why it is so, if that is not plain.
    """

    signal: str
    topic: Topic
    field: str
    pairs: Mapping[str, str]
    ranges: Mapping[str, Range]
    remark: str = ""

    @property
    def exact(self) -> bool:
        """Whether our own logs call it so."""
        own = TOPIC_NAMED.get(self.topic.channel.topic)
        return own is not None and self.signal in own.signals.values()


def propose_map(summary: LogSummary) -> str:
    """Topic map of a log as TOML; a comment says what is missing or doubtful."""
    found: dict[str, list[Proposal]] = {}
    for topic in summary.topics:
        for proposal in (*_of_messages(topic), *_of_table(topic)):
            found.setdefault(proposal.signal, []).append(proposal)
    lines = [
        f"# Proposed for {summary.path.name}; check names, signs, offsets and units (value = sign * logged + offset)."
    ]
    for signal in QUANTITIES:
        if signal in found:
            chosen: list[Proposal] = []
            for proposal in sorted(found[signal], key=lambda p: (not p.exact, -len(p.pairs), -p.topic.count)):
                if not any(proposal.pairs.keys() & other.pairs.keys() or not other.pairs for other in chosen):
                    chosen.append(proposal)  # joints may come from several topics
            entries = [line for p in chosen for line in ("", *_entry(p, _rivals(p.topic, summary)))]
            given = {channel for proposal in chosen for channel in proposal.pairs}
            absent = [channel for channel in QUANTITIES[signal].channels if given and channel not in given]
            if absent and signal != DRIVING:
                entries = [f"# {line}" if line and not line.startswith("#") else line for line in entries]
            lines += entries + (_constants(signal, absent) if absent else [])
            rest = [proposal for proposal in found[signal] if proposal not in chosen]
            lines += [f"# also possible: {other.topic.channel.topic} {other.field}" for other in rest[:3]]
    if DRIVING not in found:
        lines += ["", '# no joint angles were recognised: replay needs an entry with signal = "joint/position"']
    return "\n".join(lines) + "\n"


def _of_messages(topic: Topic) -> Iterator[Proposal]:
    name, kind = topic.channel.topic, topic.channel.type.rpartition("/")[2].rpartition(".")[2]
    own = TOPIC_NAMED.get(name)
    for path, ranges in topic.fields.items():
        last = path.rpartition(".")[2]
        if own and own.kind.ros_type == topic.channel.type:
            for field, signal in own.signals.items():
                if FIELDS.get(field, field) == path:
                    yield _known(signal, topic, path, ranges)
        elif CYLINDER.search("/".join((name, *ranges))) and last in ("effort", "force", "position", "length", "data"):
            signal = "cylinder/force" if last in ("effort", "force") or FORCE.search(name) else "cylinder/length"
            yield from _numbered(signal, CYLINDER, "cylinder", topic, path, ranges)
        elif kind == "Imu" and last in ("linear_acceleration", "angular_velocity"):
            place = LINK.search("/".join((name, *topic.frames)))
            if place:
                what = "specific_force" if last == "linear_acceleration" else "angular_rate"
                yield Proposal(f"imu/link{place[1]}/{what}", topic, path, {axis: axis for axis in "xyz"}, ranges)
        elif kind == "PoseArray" and last == "position":
            signal = "markers" if len(ranges) == len(QUANTITIES["markers"].channels) else "markers/truck"
            yield Proposal(signal, topic, path, {}, ranges)
        elif kind.startswith("Wrench") and last == "force":
            yield Proposal("load", topic, path, {axis: axis for axis in "xyz"}, ranges)
        elif last in ("position", "positions", "velocity", "data", "value") and topic.channel.encoding != "row":
            command = bool(COMMANDED.search(f"{name}/{path}"))
            if last == "velocity" and not command:
                continue
            signal = (
                f"joint_command/{last}"
                if command and last == "velocity"
                else ("joint_command/position" if command else "joint/position")
            )
            yield from _joints(signal, topic, path, ranges)


def _known(signal: str, topic: Topic, path: str, ranges: Mapping[str, Range]) -> Proposal:
    channels = () if QUANTITIES[signal].points else QUANTITIES[signal].channels
    if set(channels) <= set(ranges):
        return Proposal(signal, topic, path, {channel: channel for channel in channels}, ranges)
    return next(_joints(signal, topic, path, ranges), Proposal(signal, topic, path, {}, ranges, "names not recognised"))


def _joints(signal: str, topic: Topic, path: str, ranges: Mapping[str, Range]) -> Iterator[Proposal]:
    """Joints by their names, or their numbers, or, if there are just five names without, by their order."""
    joints, names, remark = QUANTITIES[signal].channels, tuple(ranges), ""
    pairs = {joint: joint for joint in joints if joint in names}
    if not pairs:
        matched = {name: int(place[1]) for name in names if (place := JOINT.search(name))}
        if len(names) == 1 and not matched and (place := JOINT.search(topic.channel.topic)):
            matched = {names[0]: int(place[1])}
        slewing = [name for name in names if name not in matched and SLEW.search(name)]
        if len(slewing) == 1 and 5 not in matched.values():
            matched = {slewing[0]: 1, **{name: number + 1 for name, number in matched.items()}}
            remark = "joint1 is what slews, and the others are counted from there: a guess"
        pairs = {f"joint{number}": name for name, number in sorted(matched.items(), key=lambda item: item[1])}
        if len(pairs) < len(matched) or (not pairs and len(names) != len(joints)):
            return
        if not pairs:
            pairs, remark = dict(zip(joints, names)), "the order of the joints is a guess"
    yield Proposal(signal, topic, path, pairs, ranges, remark)


def _numbered(
    signal: str, pattern: re.Pattern[str], prefix: str, topic: Topic, path: str, ranges: Mapping[str, Range]
) -> Iterator[Proposal]:
    pairs = {f"{prefix}{place[1]}": name for name in ranges if (place := pattern.search(name))}
    if pairs:
        yield Proposal(signal, topic, path, dict(sorted(pairs.items())), ranges)


def _of_table(topic: Topic) -> Iterator[Proposal]:
    """Columns of a table, by their names."""
    found: dict[str, dict[str, str]] = {}
    joints: dict[str, dict[str, Range]] = {}
    ranges = topic.fields.get(ALL, {}) if topic.channel.encoding == "row" else {}
    for name in ranges:
        axis = AXIS.search(name)
        letter = (axis[1] or axis[2]).lower() if axis else ""
        if TIME.match(name):
            continue
        if (place := CYLINDER.search(name)) is not None:
            signal = "cylinder/force" if FORCE.search(name) else "cylinder/length"
            found.setdefault(signal, {}).setdefault(f"cylinder{place[1]}", name)
        elif letter and (place := LINK.search(name)) and (ACCELERATION.search(name) or RATE.search(name)):
            what = "specific_force" if ACCELERATION.search(name) and not RATE.search(name) else "angular_rate"
            found.setdefault(f"imu/link{place[1]}/{what}", {}).setdefault(letter, name)
        elif JOINT.search(name) or SLEW.search(name):
            rate = RATE.search(name)
            signal = (
                f"joint_command/{'velocity' if rate else 'position'}" if COMMANDED.search(name) else "joint/position"
            )
            if signal != "joint/position" or not (rate or FORCE.search(name)):
                joints.setdefault(signal, {})[name] = ranges[name]
    for signal, columns in joints.items():
        yield from _joints(signal, topic, ALL, columns)
    for signal, pairs in found.items():
        yield Proposal(signal, topic, ALL, dict(sorted(pairs.items())), ranges)


def _rivals(topic: Topic, summary: LogSummary) -> list[int]:
    """Other channels that send the same names on the same topic at the same time."""

    def names(other: Topic) -> set[tuple[str, str]]:
        return {(path, name) for path, ranges in other.fields.items() for name in ranges}

    return [
        other.channel.id
        for other in summary.topics
        if other is not topic
        and other.channel.topic == topic.channel.topic
        and names(other) & names(topic)
        and (other.log and topic.log and other.log.start <= topic.log.stop and topic.log.start <= other.log.stop)
    ]


def _entry(proposal: Proposal, rivals: list[int]) -> list[str]:
    signal, topic, quantity = proposal.signal, proposal.topic, QUANTITIES[proposal.signal]
    names = tuple(proposal.pairs.values()) or tuple(proposal.ranges)
    largest = max((proposal.ranges[name].largest for name in names), default=0.0)
    unit = guess_unit(signal, largest, names, bool(SI.search(topic.channel.type)))
    missing = sum(proposal.ranges[name].missing for name in names)
    remarks = [proposal.remark] if proposal.remark else []
    if missing:
        remarks.append(f"{missing} values are NaN")
    remarks.append(f"largest value {largest:.4g}" + (", so the unit is a guess" if unit.endswith(GUESS) else ""))
    lines = [f"# {'; '.join(remarks)}", "[[entry]]", f'signal = "{signal}"']
    role = "commanded" if signal.startswith("joint_command") else "measured"
    lines += [f'role = "{role}"', f"topic = {_text(topic.channel.topic)}", f"field = {_text(proposal.field)}"]
    if rivals:
        lines.append(f"publisher = {topic.channel.id}  # channel {', '.join(map(str, rivals))} sends the same names")
    if proposal.pairs:
        lines.append(f"from = [{', '.join(map(_text, proposal.pairs.values()))}]")
        lines.append(f"to = [{', '.join(map(_text, proposal.pairs))}]")
        ones, zeros = ", ".join("1" for _ in proposal.pairs), ", ".join("0.0" for _ in proposal.pairs)
        lines += [f"sign = [{ones}]", f"offset = [{zeros}]"]
    lines += [f'unit = "{unit}"  # one of {", ".join(UNITS[quantity.unit])}', *_time(topic)]
    return lines


def _constants(signal: str, absent: list[str]) -> list[str]:
    """What to write for channels that the log lacks."""
    return [
        f"# {', '.join(absent)} not found; what stood still can be given as a constant:",
        "# [[entry]]",
        f'# signal = "{signal}"',
        f"# to = [{', '.join(map(_text, absent))}]",
        f"# constant = [{', '.join('0.0' for _ in absent)}]",
        f'# unit = "{QUANTITIES[signal].unit}"',
    ]


def _time(topic: Topic) -> list[str]:
    """The time base: for a table its time column, whose unit is guessed from the step."""
    if topic.channel.encoding != "row":
        return [f'time = "{topic.time_base}"']
    column = next((name for name in topic.own if TIME.match(name)), next(iter(topic.own), None))
    if column is None:
        return ['# no column increases as a time does: say time = "COLUMN"']
    step = 1 / topic.own[column].rate_hz if topic.own[column].rate_hz else 0.0
    named = TIME.match(column)
    if named and named[3]:
        unit = named[3].lower()
    else:
        unit = next(
            u
            for u, most in (("s", 1.0), ("ms" + GUESS, 1e3), ("us" + GUESS, 1e6), ("ns" + GUESS, 1e300))
            if step < most
        )
    return [f"time = {_text(column)}", f'time_unit = "{unit}"  # the usual step is {step:.6g}']


def _text(value: str) -> str:
    """A TOML string."""
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
