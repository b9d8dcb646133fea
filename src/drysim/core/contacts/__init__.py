"""Contacts: a spring that holds, yields and lifts off in place of rigid sticking."""
