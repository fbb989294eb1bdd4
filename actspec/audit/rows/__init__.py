"""Ledger rows: from models and specs (`robot`), from configurations (`config`)."""
