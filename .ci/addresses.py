"""Write the address of the project in place of its placeholder: ``python .ci/addresses.py https://HOST/OWNER/NAME``.

Files have the placeholder, as long as it is not known where the project stands. The workflow that releases calls this
with the address of its repository, before it builds anything.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PLACEHOLDER = "https://flangeway.invalid"
"""Names below ``.invalid`` have no owner, and never will (RFC 2606)."""
FILES = (
    "pyproject.toml",
    "studies/pyproject.toml",
    "mkdocs.yml",
    "CITATION.cff",
    "SECURITY.md",
    ".github/ISSUE_TEMPLATE/config.yml",
)
"""All files that have it; a test compares."""


def main(arguments: list[str]) -> int:
    """Replace it in every file."""
    if len(arguments) != 1 or not arguments[0].startswith("https://"):
        print("give one address, https://HOST/OWNER/NAME", file=sys.stderr)
        return 2
    for name in FILES:
        file = ROOT / name
        text = file.read_text(encoding="utf-8").replace(PLACEHOLDER, arguments[0].rstrip("/"))
        file.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
