"""`python -m mobilegs`, and what torchrun starts: `torchrun ... -m mobilegs train ...`."""

import sys

from mobilegs.cli import main

sys.exit(main())
