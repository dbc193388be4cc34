use super::*;

#[test]
fn shards_are_all_pieces_in_order() {
    for (pieces, of) in [(6, 6), (7, 3), (54_000, 1000), (usize::MAX, 12)] {
        let ranges: Vec<_> = (1..=of).map(|shard| Share { shard, of }.of_pieces(pieces)).collect();
        assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, pieces));
        assert!(ranges.iter().zip(&ranges[1..]).all(|(one, next)| one.end == next.start && !one.is_empty()));
        let lengths = ranges.iter().map(ExactSizeIterator::len);
        assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
    }
}

#[test]
fn shares_are_read_and_named() {
    assert_eq!("3/12".parse(), Ok(Share { shard: 3, of: 12 }));
    assert_eq!(Share { shard: 3, of: 12 }.file_name(), "03-of-12.shard");
    for text in ["0/12", "13/12", "1", "1/0", "a/b", "1/1000001", "-1/3", ""] {
        assert!(text.parse::<Share>().is_err(), "{text}");
    }
}
