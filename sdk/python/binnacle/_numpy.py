# SPDX-License-Identifier: Apache-2.0
"""numpy, also where python3 has none: another one than Debian's (pyenv's, conda's) often stands first in PATH.

The module is made for one minor version of Python, as Debian's numpy is; of that version, any python3 may use both.
"""

import sys

try:
    import numpy as _  # noqa: F401
except ImportError:
    sys.path.append("/usr/lib/python3/dist-packages")
    try:
        import numpy as _  # noqa: F401
    except ImportError as error:
        raise ImportError(
            f"binnacle needs numpy, and {sys.executable} has none (Debian: python3-numpy, for /usr/bin/python3): {error}"
        ) from None
