//! One layer as one operation of candle: x W + b, then ReLU, and its derivative.
//!
//! candle 0.11 asks the system for its processors before every product of matrices (reading `/proc/cpuinfo` on Linux,
//! unless `RAYON_NUM_THREADS` is set). With matrices this small that took five times as long as all the arithmetic;
//! nalgebra multiplies at once, on one thread.

use candle_core::{CpuStorage, CustomOp3, Error, Layout, Result, Shape, Tensor};
use nalgebra::{DMatrix, DMatrixView};

/// Inputs (rows × in), weights (in × out), biases (1 × out) to rows × out.
///
/// candle stores by rows, nalgebra by columns: every matrix here is the transpose of its tensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dense {
    /// Negative sums become 0.
    pub(super) relu: bool,
}

impl CustomOp3 for Dense {
    fn name(&self) -> &'static str {
        "dense"
    }

    fn cpu_fwd(
        &self,
        inputs: &CpuStorage,
        inputs_at: &Layout,
        weight: &CpuStorage,
        weight_at: &Layout,
        bias: &CpuStorage,
        bias_at: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let inputs = view(inputs.as_slice()?, inputs_at)?;
        let weight = view(weight.as_slice()?, weight_at)?;
        let bias = view(bias.as_slice()?, bias_at)?;
        let mut outputs = DMatrix::from_fn(weight.nrows(), inputs.ncols(), |output, _| bias[output]);
        outputs.gemm(1.0, &weight, &inputs, 1.0);
        if self.relu {
            outputs.apply(|output| *output = output.max(0.0));
        }
        let shape = Shape::from((outputs.ncols(), outputs.nrows()));
        Ok((CpuStorage::F32(outputs.data.into()), shape))
    }

    fn bwd(
        &self,
        inputs: &Tensor,
        weight: &Tensor,
        _: &Tensor,
        outputs: &Tensor,
        gradient: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let mut gradient = matrix(gradient)?;
        if self.relu {
            // The derivative at 0 itself is 0, as in scikit-learn.
            gradient.zip_apply(&matrix(outputs)?, |slope, output| {
                *slope = if output > 0.0 { *slope } else { 0.0 };
            });
        }
        let to_inputs = if inputs.track_op() {
            Some(tensor(matrix(weight)?.transpose() * &gradient, inputs)?)
        } else {
            None
        };
        let to_bias =
            Tensor::from_slice(gradient.column_sum().as_slice(), (1, gradient.nrows()), inputs.device())?;
        let to_weight = tensor(&gradient * matrix(inputs)?.transpose(), weight)?;
        Ok((to_inputs, Some(to_weight), Some(to_bias)))
    }
}

fn view<'a>(values: &'a [f32], layout: &Layout) -> Result<DMatrixView<'a, f32>> {
    let (rows, columns) = layout.shape().dims2()?;
    let values = layout.contiguous_offsets().and_then(|(from, to)| values.get(from..to));
    let values = values.ok_or_else(|| Error::Msg("dense: expected contiguous tensors".to_owned()))?;
    Ok(DMatrixView::from_slice(values, columns, rows))
}

fn matrix(tensor: &Tensor) -> Result<DMatrix<f32>> {
    let (rows, columns) = tensor.dims2()?;
    Ok(DMatrix::from_vec(columns, rows, tensor.flatten_all()?.to_vec1()?))
}

/// In the shape of another.
fn tensor(matrix: DMatrix<f32>, like: &Tensor) -> Result<Tensor> {
    Tensor::from_vec(matrix.data.into(), like.shape(), like.device())
}

#[cfg(test)]
mod tests {
    use super::Dense;
    use candle_core::{Device, Result, Tensor, Var};

    /// Value and derivatives agree with candle's own product, sum and ReLU; sums of at most 9 terms of about 1 in f32
    /// differ by less than 1e-5.
    #[test]
    fn agrees_with_candle() -> Result<()> {
        let wave = |count: usize, k: f32| (0..count).map(|i| (i as f32 * k).sin()).collect::<Vec<_>>();
        let inputs = Var::from_vec(wave(9 * 7, 0.7), (9, 7), &Device::Cpu)?;
        let weight = Var::from_vec(wave(7 * 6, 1.3), (7, 6), &Device::Cpu)?;
        let bias = Var::from_vec(wave(6, 2.1), (1, 6), &Device::Cpu)?;
        let slopes = Tensor::from_vec(wave(9 * 6, 0.3), (9, 6), &Device::Cpu)?;
        for relu in [false, true] {
            let ours = inputs.apply_op3(&weight, &bias, Dense { relu })?;
            let sum = inputs.matmul(&weight)?.broadcast_add(&bias)?;
            let theirs = if relu { sum.relu()? } else { sum };
            close(&ours, &theirs)?;
            let (ours, theirs) = ((ours * &slopes)?.backward()?, (theirs * &slopes)?.backward()?);
            for var in [&inputs, &weight, &bias] {
                close(ours.get(var).unwrap(), theirs.get(var).unwrap())?;
            }
        }
        Ok(())
    }

    fn close(a: &Tensor, b: &Tensor) -> Result<()> {
        assert_eq!(a.dims(), b.dims());
        let apart = (a - b)?.abs()?.max_all()?.to_scalar::<f32>()?;
        assert!(apart < 1e-5, "{apart}");
        Ok(())
    }
}
