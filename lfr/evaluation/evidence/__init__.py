"""The evidence: results/paper read, put together over seeds, shown as tables, figures and text."""
