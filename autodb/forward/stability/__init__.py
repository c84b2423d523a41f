"""Which depths of cut chatter: a compliant tool point and a chip that remembers the last one."""
