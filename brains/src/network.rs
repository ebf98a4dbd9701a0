//! Small feedforward networks of neurons, as descriptions have them: of a state variable, and of a [policy](crate::policy).

use baudbot_geometry::math;

/// A feedforward network of neurons whose answer is tanh of the weighted sum of what comes in.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// Layer by layer, neuron by neuron: a weight for each input, and the bias last.
    pub layers: Vec<Vec<Vec<f64>>>,
}

/// A fault in a network's shape.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Misfit {
    /// The place among the layers, such as `[0][2]`; empty if it is all of them.
    pub(crate) place: String,
    /// The problem, and what is needed.
    pub(crate) problem: String,
}

impl Network {
    /// The answers of the last layer's neurons.
    pub fn answers(&self, inputs: Vec<f64>) -> Vec<f64> {
        let answers = |inputs: Vec<f64>, layer: &Vec<Vec<f64>>| {
            layer.iter().map(|weights| neuron(weights, &inputs)).collect()
        };
        self.layers.iter().fold(inputs, answers)
    }

    /// The answer of the last layer's first neuron.
    pub fn answer(&self, inputs: Vec<f64>) -> f64 {
        self.answers(inputs).first().copied().unwrap_or(0.0)
    }

    /// The reason why it is no network of so many inputs with one answer, if it is none.
    pub fn problem(&self, inputs: usize) -> Option<String> {
        let said = |Misfit { place, problem }| format!("network{place}: {problem}");
        self.misfit(inputs).map(said).or_else(|| match self.layers.last()?.len() {
            1 => None,
            neurons => Some(format!("network: its last layer must have one neuron, and has {neurons}")),
        })
    }

    /// The fault that makes it no network of so many inputs, if it is none.
    pub(crate) fn misfit(&self, inputs: usize) -> Option<Misfit> {
        let at = |place, problem| Some(Misfit { place, problem });
        if self.layers.is_empty() {
            return at(String::new(), "has no layer".to_owned());
        }
        let mut comes_in = inputs;
        for (i, layer) in self.layers.iter().enumerate() {
            if let Some((j, weights)) =
                layer.iter().enumerate().find(|(_, weights)| weights.len() != comes_in + 1)
            {
                let (has, needs) = (weights.len(), comes_in + 1);
                let problem =
                    format!("has {has} numbers, and needs {needs}: {comes_in} weights and the bias");
                return at(format!("[{i}][{j}]"), problem);
            }
            comes_in = layer.len();
        }
        None
    }
}

fn neuron(weights: &[f64], inputs: &[f64]) -> f64 {
    let Some((bias, weights)) = weights.split_last() else { return 0.0 };
    math::tanh(bias + weights.iter().zip(inputs).map(|(weight, input)| weight * input).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_can_do_what_no_sum_can() {
        // One of two, and not both: -1 and 1 stand for no and yes.
        let either = vec![2.0, 2.0, 2.0];
        let both = vec![2.0, 2.0, -2.0];
        let network = Network { layers: vec![vec![either, both], vec![vec![2.0, -2.0, -2.0]]] };
        assert_eq!(network.problem(2), None);
        for (a, b, is) in [(-1.0, -1.0, false), (-1.0, 1.0, true), (1.0, -1.0, true), (1.0, 1.0, false)] {
            assert_eq!(network.answer(vec![a, b]) > 0.0, is, "{a} {b}");
        }
        assert_eq!(
            network.problem(3).unwrap(),
            "network[0][0]: has 3 numbers, and needs 4: 3 weights and the bias"
        );
    }

    #[test]
    fn a_network_without_layers_or_with_two_answers_is_no_state_variable() {
        let problem = |layers| Network { layers }.problem(1).unwrap();
        assert_eq!(problem(vec![]), "network: has no layer");
        let two = vec![vec![vec![0.0, 1.0], vec![0.0, -1.0]]];
        assert_eq!(problem(two), "network: its last layer must have one neuron, and has 2");
    }
}
