"""What people look at: pictures, the HTML report, and files for ParaView; Matplotlib is loaded when it draws."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # the names are in __init__.pyi
