"""Puts what bench/gpu/run.sh made, and is small, into archives: see `pack` in bench/paper_cells.py.

python bench/gpu/packed.py RUNS OUT
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from paper_cells import pack


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    pack(options.runs, options.out)


if __name__ == "__main__":
    main()
