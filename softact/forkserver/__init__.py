"""Fork servers: where many processes of one kind are started (a sweep, the tests), each is forked
from a process that has loaded its libraries, instead of loading them anew, which takes a small run
most of its time.

``servers.py`` belongs to the process that starts others, ``server.py`` is the process that forks,
and ``client.py`` stands for a forked process: it hands over its arguments, variables, limits and
open files and ends as that process does. Whoever starts, waits for, stops or kills the client
needs to know nothing of all this.
"""

from softact.forkserver.servers import command

__all__ = ["command"]
