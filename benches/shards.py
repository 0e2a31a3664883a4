"""How long a campaign of 10^6 cases takes on 256 cores, dealt out in virtual time: `python3 benches/shards.py`.

Each core takes the next shard when it is done with one. Of the 40,000 rigs some are slower than others as a whole (coefficient of
variation 0.5), and so are the 25 cases of each (1); a case takes 4.5 s in the mean, a shard 25 ms beyond its cases.
"""

import heapq
import random

CASES, CORES, RIGS = 1_000_000, 256, 40_000
CASE, SHARD = 4.5, 0.025


def rig() -> float:
    """Seconds that the cases of one rig take."""
    each = CASES / RIGS
    return random.lognormvariate(-0.1116, 0.4724) * CASE * max(0.0, random.gauss(each, each**0.5))


def campaign(shards: int) -> tuple[float, float]:
    """Hours, and the share of them in which cores work on cases."""
    ends, work = [0.0] * CORES, 0.0
    base, more = divmod(RIGS, shards)
    for shard in range(shards):
        takes = sum(rig() for _ in range(base + (shard < more)))
        work += takes
        heapq.heappush(ends, heapq.heappop(ends) + takes + SHARD)
    return max(ends) / 3600, work / (max(ends) * CORES)


if __name__ == "__main__":
    random.seed(1)
    for each in (1, 4, 10, 40):
        hours, efficiency = campaign(each * CORES)
        print(f"{each:3} shards for each core: {hours:.2f} h, {efficiency:.1%}")
