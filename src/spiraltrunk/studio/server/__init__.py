"""The server of the page: who may open it, and what may arrive from it."""
