"""Other ANFIS libraries, each in a process of an environment of its own: see ``benchmarks.anfis``.

python -m venv PEERS
PEERS/bin/pip install -r benchmarks/anfis_peers/requirements.txt
"""
