"""A page in the browser on which a wheelset is moved: rigid contact at once, patches and forces when it stands."""

from flangeway.live.server import LiveServer
from flangeway.live.widget import LiveWidget

__all__ = ["LiveServer", "LiveWidget"]
