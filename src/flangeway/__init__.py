"""Elastic contact in two dimensions with finite and virtual elements, up to a wheelset on two rails."""
