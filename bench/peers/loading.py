"""CPU time of building a model."""

import time
from collections.abc import Callable


def timed(build: Callable[[], object]) -> float:
    begin = time.process_time()
    build()
    return time.process_time() - begin
