"""First file a Blender in another process runs: makes regraft importable, then serves.

Usage: `blender -b --python bootstrap.py -- JSON` or `python bootstrap.py -- JSON`.
"""

from __future__ import annotations

import importlib.util
import json
import sys


def _load_native(path: str) -> None:
    spec = importlib.util.spec_from_file_location("regraft._regraft", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no module this Python {sys.version_info[:2]} can load")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)


def main() -> None:
    """Appends, never puts in front: Blender's own packages must win."""
    roots = json.loads(sys.argv[sys.argv.index("--") + 1])
    if sys.path and sys.path[0].endswith("cli"):
        del sys.path[0]  # this file's own folder holds modules with common names
    sys.path.extend(folder for folder in roots["folders"] if folder not in sys.path)
    _load_native(roots["native"])
    from regraft.cli.protocol import serve

    serve()


if __name__ == "__main__":
    main()
