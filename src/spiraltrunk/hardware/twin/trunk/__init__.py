"""What a twin's drums pull on: reduced trunks, fixed ends, and slack in between."""
