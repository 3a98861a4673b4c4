"""Many runs: designs over the paths of a spec, computed once each and kept in a cache."""

import sys

from softact.callable_rooms import CallableRoom

sys.modules[__name__].__class__ = CallableRoom  # softact.sweep(...) is softact.api.sweep
