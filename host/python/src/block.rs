//! Ticks as arrays: one for each quantity, by its name in the table of columns.

use armbridge_client::simulation::TrueState;
use armbridge_link::message::Record;
use armbridge_log::export::column::{QUANTITIES, Quantity, Values, Words};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use armbridge_client::params::nearest;

/// Ticks in order, whose quantities are arrays: `block["angle_rad"]` has shape (n, 2), what the
/// board has once has shape (n,). An array is made of the records when it is asked for.
#[pyclass(frozen, mapping, module = "armbridge")]
pub(crate) struct Block {
    records: Vec<Vec<Record>>,
    /// True states of a simulated arm, one for each record; empty without.
    truths: Vec<Option<TrueState>>,
}

impl Block {
    pub(crate) fn new(records: Vec<Vec<Record>>, truths: Vec<Option<TrueState>>) -> Self {
        Self { records, truths }
    }

    fn records(&self) -> impl Iterator<Item = &Record> {
        self.records.iter().flatten()
    }

    fn quantities(&self) -> impl Iterator<Item = &'static Quantity> {
        let has_truth = !self.truths.is_empty();
        QUANTITIES
            .iter()
            .filter(move |it| has_truth || !matches!(it.values, Values::Truth(_)))
    }

    /// Values of a quantity: of each record, of each joint.
    fn array<T: numpy::Element>(
        &self,
        py: Python<'_>,
        width: usize,
        value: impl Fn(&Record, usize) -> T + Sync,
    ) -> PyResult<Py<PyAny>> {
        let values: Vec<T> = py.detach(|| {
            let mut values = Vec::with_capacity(self.len() * width);
            for record in self.records() {
                values.extend((0..width).map(|joint| value(record, joint)));
            }
            values
        });
        shaped(values.into_pyarray(py), self.len(), width)
    }

    fn truth(
        &self,
        py: Python<'_>,
        width: usize,
        get: fn(&TrueState, usize) -> f32,
    ) -> PyResult<Py<PyAny>> {
        let value =
            |state: &Option<TrueState>, joint| state.as_ref().map_or(f32::NAN, |it| get(it, joint));
        let states = self.truths.iter();
        let values: Vec<f32> = states
            .flat_map(|state| (0..width).map(move |joint| value(state, joint)))
            .collect();
        shaped(values.into_pyarray(py), self.len(), width)
    }

    fn words(
        &self,
        py: Python<'_>,
        width: usize,
        words: Words,
        get: fn(&Record, usize) -> usize,
    ) -> PyResult<Py<PyAny>> {
        // An array is as wide as its longest word: those that do not occur are left out.
        let all = words.all();
        let mut places = vec![None; all.len()];
        let mut used = Vec::new();
        let codes = py.detach(|| {
            let mut codes = Vec::with_capacity(self.len() * width);
            for record in self.records() {
                codes.extend((0..width).map(|joint| {
                    let code = get(record, joint);
                    *places[code].get_or_insert_with(|| {
                        used.push(&all[code]);
                        (used.len() - 1) as u8
                    })
                }));
            }
            codes
        });
        let words = py.import("numpy")?.call_method1("array", (used, "U"))?;
        let codes = shaped(codes.into_pyarray(py), self.len(), width)?;
        Ok(words.call_method1("take", (codes,))?.unbind())
    }
}

/// An array of shape (n,), or (n, width) if there is one column for each joint.
fn shaped<T: numpy::Element>(
    values: Bound<'_, PyArray1<T>>,
    len: usize,
    width: usize,
) -> PyResult<Py<PyAny>> {
    let py = values.py();
    if width == 1 {
        return values.into_py_any(py);
    }
    values.reshape([len, width])?.into_py_any(py)
}

#[pymethods]
impl Block {
    fn __len__(&self) -> usize {
        self.records.iter().map(Vec::len).sum()
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let Some(quantity) = self.quantities().find(|it| it.name == name) else {
            let names = self.quantities().map(|it| it.name);
            let is_it = nearest(name, names).map_or_else(
                || "`keys()` lists the quantities".to_owned(),
                |near| format!("is it '{near}'?"),
            );
            return Err(PyKeyError::new_err(format!(
                "no quantity '{name}'; {is_it}"
            )));
        };
        let width = quantity.columns.len();
        match quantity.values {
            Values::F64(get) => self.array(py, width, |record, _| get(record)),
            Values::F32(get) => self.array(py, width, get),
            Values::U32(get) => self.array(py, width, |record, _| get(record)),
            Values::U16(get) => self.array(py, width, get),
            Values::Sample(get) => self.array(py, width, |record, joint| {
                get(record, joint).map_or(f32::NAN, f32::from)
            }),
            Values::Word(words, get) => self.words(py, width, words, get),
            Values::Truth(get) => self.truth(py, width, get),
        }
    }

    fn __contains__(&self, name: &str) -> bool {
        self.quantities().any(|it| it.name == name)
    }

    fn __iter__(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self
            .keys()
            .into_py_any(py)?
            .bind(py)
            .try_iter()?
            .into_any()
            .unbind())
    }

    fn __repr__(&self) -> String {
        format!("<Block of {} ticks>", self.len())
    }

    /// Names of the quantities.
    fn keys(&self) -> Vec<&'static str> {
        self.quantities().map(|it| it.name).collect()
    }

    /// Unit of a quantity, as `rad`; empty for words and plain numbers.
    fn unit(&self, name: &str) -> PyResult<&'static str> {
        let quantity = self.quantities().find(|it| it.name == name);
        quantity
            .map(|it| it.unit)
            .ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }

    /// A table with one column for each quantity and joint, as in the Parquet export.
    pub(crate) fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let columns = pyo3::types::PyDict::new(py);
        for quantity in slf.get().quantities() {
            let values = slf.get().__getitem__(py, quantity.name)?.into_bound(py);
            match quantity.columns {
                [name] => columns.set_item(name, values)?,
                names => {
                    let transposed = values.getattr("T")?;
                    for (joint, name) in names.iter().enumerate() {
                        columns.set_item(name, transposed.get_item(joint)?)?;
                    }
                }
            }
        }
        py.import("pandas")?.call_method1("DataFrame", (columns,))
    }
}

impl Block {
    pub(crate) fn len(&self) -> usize {
        self.__len__()
    }
}
