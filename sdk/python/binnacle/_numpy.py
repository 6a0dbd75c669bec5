# SPDX-License-Identifier: Apache-2.0
"""numpy, before anything else of the package wants it.

Debian's python3 has it. Another python3 of the same version that has none (pyenv's, say) borrows Debian's, and nothing else of Debian's.
"""

import importlib.machinery
import importlib.util
import sys

DEBIANS = "/usr/lib/python3/dist-packages"


def borrow():
    """Debian's numpy as a module; ImportError where there is none that fits."""
    spec = importlib.machinery.PathFinder.find_spec("numpy", [DEBIANS])
    if spec is None or spec.loader is None:
        raise ImportError(f"binnacle needs numpy, which {sys.executable or 'this python3'} does not have (Debian package python3-numpy)")
    module = importlib.util.module_from_spec(spec)
    sys.modules["numpy"] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules["numpy"]
        raise


if importlib.util.find_spec("numpy") is None:
    borrow()
