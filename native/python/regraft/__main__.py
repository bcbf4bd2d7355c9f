"""`python -m regraft` is the `regraft` command."""

from __future__ import annotations

import sys

from regraft.cli import main

if __name__ == "__main__":
    sys.exit(main())
