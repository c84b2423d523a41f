"""Recordings that are sent: received, read apart, imported; machines that learn, apart."""
