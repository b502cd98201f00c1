"""Options that several verbs have, and what is built from them."""
