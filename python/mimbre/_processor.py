"""Reports processor instructions that the package needs and the processor lacks, before one of them ends Python."""

from collections.abc import Collection
from pathlib import Path

#: What x86-64-v3 has beyond the first x86-64, in the words of Linux.
X86_64_V3 = frozenset(
    [
        "sse3",
        "ssse3",
        "sse4_1",
        "sse4_2",
        "popcnt",
        "cx16",
        "avx",
        "avx2",
        "bmi1",
        "bmi2",
        "f16c",
        "fma",
        "abm",
        "movbe",
    ]
)


def check(built_for: str, flags: Collection[str]) -> None:
    """ImportError where a processor with these flags has not all that `built_for` asks, an `-march` of the compiler."""
    if built_for != "x86-64-v3":
        return  # any processor, or the very one that compiled it
    # /proc/cpuinfo calls SSE3 by its first name.
    missing = X86_64_V3 - set(flags) - ({"sse3"} if "pni" in flags else set())
    if missing:
        raise ImportError(
            f"this package of mimbre is compiled for processors of the level x86-64-v3 (Intel and AMD since 2013 to "
            f"2015), and this one has no {', '.join(sorted(missing))}; build it here instead, from its sources: "
            f"pip install --no-binary mimbre mimbre"
        )


def flags() -> list[str] | None:
    """Those of the first core, or None where the system does not report them."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as lines:
            for line in lines:
                if line.startswith("flags"):
                    return line.partition(":")[2].split()
    except OSError:
        pass
    return None


known = flags()
if known is not None:
    check(Path(__file__).with_name("processor.txt").read_text(encoding="utf-8").strip(), known)
