"""Campaigns: one case over many inputs, computed by many processes into one SQLite file."""

from flangeway.study.campaign.campaign import Campaign, Row
from flangeway.study.campaign.run import CampaignProgress, run_campaign
from flangeway.study.campaign.table import CampaignTable, results

__all__ = ["Campaign", "CampaignProgress", "CampaignTable", "Row", "results", "run_campaign"]
