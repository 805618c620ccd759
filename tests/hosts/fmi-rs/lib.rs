//! Nothing: the host is the test.
