"""Alembic runs the migrations on the connection that autodb.store hands it.

SQLite changes a table by copying it and dropping the old one; with foreign keys on, dropping would
delete the rows that point to it. So they are off, and autodb.store checks them before it commits.
"""

from alembic import context

from autodb.store.models import Base

connection = context.config.attributes["connection"]
if connection.dialect.name == "sqlite":
    assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 0

context.configure(
    connection=connection,
    target_metadata=Base.metadata,
    transactional_ddl=True,
)
with context.begin_transaction():
    context.run_migrations()
