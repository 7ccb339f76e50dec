"""Campaigns: one case over many inputs, computed by many processes into one SQLite file."""

from flangeway.campaign.campaign import Campaign, Row
from flangeway.campaign.campaign_run import CampaignProgress, run_campaign
from flangeway.campaign.database import CampaignTable, results

__all__ = ["Campaign", "CampaignProgress", "CampaignTable", "Row", "results", "run_campaign"]
