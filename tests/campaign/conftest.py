"""Campaigns that are computed in this process."""

from pathlib import Path

from flangeway.campaign import Campaign, CampaignTable, results
from flangeway.campaign.campaign_run import RowTask, compute
from flangeway.campaign.database import CampaignDatabase


def read(folder: Path, text: str) -> Campaign:
    """The campaign of a file with this text."""
    (folder / "c.toml").write_text(text, encoding="utf-8")
    return Campaign.from_file(folder / "c.toml")


def computed(folder: Path, text: str) -> tuple[Campaign, CampaignTable]:
    """A campaign and its results: what waits in its database is computed."""
    campaign = read(folder, text)
    with CampaignDatabase(folder / "c.sqlite") as store:
        store.begin(campaign)
        waiting = store.waiting()
        for first, rows in campaign.chunks:
            for row in rows:
                if row.number in waiting:
                    store.store(row, compute(RowTask(row, first)).result)
    return campaign, results(folder / "c.sqlite")
