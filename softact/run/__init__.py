"""One run: from a spec to its folder."""

import sys

from softact.callable_rooms import CallableRoom

sys.modules[__name__].__class__ = CallableRoom  # softact.run(...) is softact.api.run
