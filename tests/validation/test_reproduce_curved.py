"""Curved edges beside chords: `flangeway reproduce curved`."""
