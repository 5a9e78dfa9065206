//! Ten million streams of bytes into each parser, and scripts for the store.

armbridge_tests::stream_tests!(10_000_000);
