//! Networks of a few bytes as ONNX files, for tests: a model is a protobuf message of nodes,
//! constants, inputs and outputs (`onnx.proto` of the ONNX project).

/// What a network answers with.
pub(crate) enum Answer {
    /// Always these values.
    Values(Vec<f32>),
    /// How bright the square is, 0 to 1.
    Brightness,
}

/// A network that takes a square of `side` by `side` pixels and answers so.
pub(crate) fn onnx(side: usize, answers: &[Answer]) -> Vec<u8> {
    let mut graph = text(2, "test");
    graph.extend(message(11, &value("square", &[1, side, side, 3])));
    for (at, answer) in answers.iter().enumerate() {
        let [constant, output] = [format!("constant{at}"), format!("answer{at}")];
        let (input, operation) = match answer {
            Answer::Values(values) => {
                let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                let sizes = [number(1, 1), number(1, values.len() as u64)].concat();
                let tensor = [sizes, number(2, 1), text(8, &constant), message(9, &bytes)].concat();
                graph.extend(message(5, &tensor));
                (constant.as_str(), "Identity")
            }
            Answer::Brightness => ("square", "ReduceMean"),
        };
        let node = [text(1, input), text(2, &output), text(3, &output), text(4, operation)].concat();
        graph.extend(message(1, &node));
        let count = if let Answer::Values(values) = answer { vec![1, values.len()] } else { vec![1; 4] };
        graph.extend(message(12, &value(&output, &count)));
    }
    let operators = message(8, &[text(1, ""), number(2, 17)].concat());
    [number(1, 8), operators, message(7, &graph)].concat()
}

/// A tensor of fractions, by its name and its sizes.
fn value(name: &str, sizes: &[usize]) -> Vec<u8> {
    let sizes: Vec<u8> = sizes.iter().flat_map(|size| message(1, &number(1, *size as u64))).collect();
    let kind = message(1, &[number(1, 1), message(2, &sizes)].concat());
    [text(1, name), message(2, &kind)].concat()
}

fn text(field: u64, text: &str) -> Vec<u8> {
    message(field, text.as_bytes())
}

fn message(field: u64, bytes: &[u8]) -> Vec<u8> {
    [varint(field << 3 | 2), varint(bytes.len() as u64), bytes.to_vec()].concat()
}

fn number(field: u64, value: u64) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}
