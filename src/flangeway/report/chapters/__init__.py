"""What the page of validation says of each reproduction, a module each."""
