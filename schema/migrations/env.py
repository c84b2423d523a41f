"""Alembic runs the migrations on the connection that autodb.store hands it."""

from alembic import context

from autodb.store.models import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    transactional_ddl=True,
)
with context.begin_transaction():
    context.run_migrations()
