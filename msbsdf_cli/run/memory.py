"""How much memory this machine has."""

import os
import sys


def memory_bytes() -> float:
    """Of all processes together; infinite where the system does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def gigabytes(amount: float) -> str:
    """An amount of bytes in words."""
    return f"{min(amount, sys.float_info.max) / 1e9:.2g} GB"
