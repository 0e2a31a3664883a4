//! Messages to the user: the place, what is wrong there, and what would be right.
