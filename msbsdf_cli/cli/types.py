"""Types of options: what a text means, or a sentence on why it means nothing."""

import math
import string
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

from msbsdf_cli.methods.registry import METHODS


def quoted(value: Any) -> str:
    """What was typed, however long or odd, as part of a sentence."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


LEAST_ROUGHNESS, MOST_ROUGHNESS = 1e-6, 1e4
"""Far beyond any surface either way; slopes squared still have room in single precision."""

MOST_ANGLES = 100
"""In one run: each has a row of pictures, and 1.5 megabytes of bins."""


class Typed(click.ParamType):
    """What a text means, or a sentence on why it means nothing."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """What is no text is what one has meant."""
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except ValueError as error:
            self.fail(f"{error}", param, ctx)

    @abstractmethod
    def read(self, text: str) -> Any:
        """What `text` means. Raises ValueError with a sentence where that is nothing."""


class Roughness(Typed):
    """`A` or `AX,AY`, positive and finite."""

    name = "A|AX,AY"

    def read(self, text: str) -> tuple[float, float]:
        alphas = _numbers(text)
        if len(alphas) not in (1, 2) or not all(0 < a < math.inf for a in alphas):
            raise ValueError(f"{quoted(text)} is not a roughness: one or two numbers above 0.")
        if not all(LEAST_ROUGHNESS <= a <= MOST_ROUGHNESS for a in alphas):
            wanted = f"a roughness is from {LEAST_ROUGHNESS:g} to {MOST_ROUGHNESS:g}"
            raise ValueError(f"{quoted(text)} is beyond every surface: {wanted}.")
        return alphas[0], alphas[-1]


class Angles(Typed):
    """Angles in radians, or in degrees where a value ends in `deg`, separated by commas; `but` is
    none."""

    name = "T[,T...]"

    def __init__(
        self,
        low: float,
        high: float,
        where: str,
        count: int | None = None,
        but: float = math.inf,
    ) -> None:
        self.low, self.high, self.where, self.count, self.but = low, high, where, count, but

    def read(self, text: str) -> tuple[float, ...]:
        angles = []
        for part in map(str.strip, text.split(",")):
            factor = math.pi / 180 if part.endswith("deg") else 1.0
            angle = _numbers(part.removesuffix("deg"))[0] * factor
            if not self.low <= angle < self.high:
                meant = factor == 1 and self.low <= math.radians(angle) < self.high
                hint = f" Is it {part}deg?" if meant else ""
                raise ValueError(f"{quoted(part)} is not an angle {self.where}.{hint}")
            if angle == self.but:
                raise ValueError(
                    f"{quoted(part)} is not an angle of incidence: such light meets nothing."
                )
            angles.append(angle)
        if self.count is not None and len(angles) != self.count:
            raise ValueError(f"{quoted(text)}: one angle is wanted.")
        if len(angles) > MOST_ANGLES:
            raise ValueError(f"{len(angles)} angles are too many: {MOST_ANGLES} a run.")
        if len(set(angles)) < len(angles):
            raise ValueError(f"{quoted(text)} names an angle twice.")
        return tuple(angles)


class Count(Typed):
    """A whole number from `least` to `most`, also written `1e6`."""

    name = "N"

    def __init__(self, least: int = 1, even: bool = False, most: float = math.inf) -> None:
        self.least, self.even, self.most = least, even, most

    def read(self, text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            (real,) = _numbers(text, count=1)
            if not math.isfinite(real) or real != int(real):
                raise ValueError(f"{quoted(text)} is not a whole number.") from None
            number = int(real)
        if number < self.least:
            raise ValueError(f"{quoted(text)} is too few: at least {self.least} are wanted.")
        if number > self.most:
            raise ValueError(f"{quoted(text)} is too many: at most {self.most:g} are taken.")
        if self.even and number % 2:
            raise ValueError(f"{quoted(text)} is odd: an even number is wanted.")
        return number


class Real(Typed):
    """A finite number for which `holds` is true; `wanted` says so in words."""

    name = "X"

    def __init__(self, holds: Callable[[float], bool], wanted: str) -> None:
        self.holds, self.wanted = holds, wanted

    def read(self, text: str) -> float:
        (number,) = _numbers(text, count=1)
        if not (math.isfinite(number) and self.holds(number)):
            raise ValueError(f"{quoted(text)} is not {self.wanted}.")
        return number


class Numbers(Typed):
    """Numbers from `low` to `high` separated by commas, as many as `count` where it is given."""

    name = "X,X..."

    def __init__(
        self, count: int | None = None, low: float = -math.inf, high: float = math.inf
    ) -> None:
        self.count, self.low, self.high = count, low, high

    def read(self, text: str) -> tuple[float, ...]:
        numbers = _numbers(text, self.count)
        for x in numbers:
            if not self.low <= x <= self.high:
                raise ValueError(f"{x:g} is not from {self.low:g} to {self.high:g}.")
        return numbers


def _numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"{quoted(text)} is not a number.") from None
    if any(math.isnan(x) for x in numbers) or (count is not None and len(numbers) != count):
        wanted = "a number" if count in (None, 1) else f"{count} numbers"
        raise ValueError(f"{quoted(text)} is not {wanted}.")
    return numbers


class Autocorrelation(Typed):
    """The name of a spectrum, and its parameter."""

    name = "NAME[:X]"

    def read(self, text: str) -> str:
        if text == "gaussian":
            return text
        # Not above: it takes NumPy and SciPy.
        from surfaces.spectrum import spectrum

        return spectrum(text).name


class Autocorrelations(Typed):
    """One of them, or several, separated by commas, none of them twice."""

    name = "NAME[:X],..."

    def read(self, text: str) -> str | tuple[str, ...]:
        names = tuple(map(Autocorrelation().read, map(str.strip, text.split(","))))
        if len(set(names)) < len(names):
            raise ValueError(f"{quoted(text)} names an autocorrelation twice.")
        return names if len(names) > 1 else names[0]


class HeightsOf(Typed):
    """The name of a distribution of heights, and its skewness."""

    name = "NAME[:S]"

    def read(self, text: str) -> str:
        if text == "gaussian":
            return text
        # Not above: it takes NumPy and SciPy.
        from surfaces.marginal import marginal

        return marginal(text).name


UNITS = {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
LETTERS = "µμ" + string.ascii_letters


class Lengths(Typed):
    """Lengths above 0, in metres or with a unit behind them: `2e-6`, `2um`, `2um,3um`."""

    name = "X[,Y]"

    def __init__(self, most: int = 2) -> None:
        self.most = most

    def read(self, text: str) -> tuple[float, ...]:
        lengths = []
        for part in map(str.strip, text.split(",")):
            number = part.rstrip(LETTERS)
            # An exponent without digits, infinity and the like are numbers that are none.
            unit = part[len(number) :] if number else ""
            if unit and unit not in UNITS:
                raise ValueError(
                    f"{quoted(part)} is in no unit that is known: {', '.join(UNITS)}; a number "
                    "alone is in metres."
                )
            lengths.append(_numbers(number or part)[0] * UNITS.get(unit, 1.0))
        if len(lengths) > self.most or not all(0 < x < math.inf for x in lengths):
            wanted = "a length above 0" if self.most == 1 else "one or two lengths above 0"
            raise ValueError(f"{quoted(text)} is not {wanted}, such as 2e-6 or 2um.")
        return tuple(lengths)


class Methods(Typed):
    """Names of methods separated by commas, and of what else is `also` taken for one; a shell
    completes the last of them."""

    name = "NAME[,NAME...]"

    def __init__(self, also: tuple[str, ...] = ()) -> None:
        self.names = (*METHODS, *also)

    def read(self, text: str) -> tuple[str, ...]:
        names = tuple(dict.fromkeys(part.strip() for part in text.split(",")))
        for name in names:
            if name not in self.names:
                raise ValueError(f"{quoted(name)} is not a method; --help lists them.")
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        before, comma, last = incomplete.rpartition(",")
        fitting = (name for name in self.names if name.startswith(last))
        return [CompletionItem(f"{before}{comma}{name}") for name in fitting]
