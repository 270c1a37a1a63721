//! A table in memory: columns with units, for every library that takes Arrow.

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, UInt32Type};
use arrow_array::{Array, RecordBatch, RecordBatchIterator};
use arrow_schema::ffi::FFI_ArrowSchema;
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyCapsule, PyDict};
use robhaz_record::BatchBuilder;

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, module = "robhaz")]
pub struct Table {
    #[pyo3(get)]
    pub name: String,
    pub batch: RecordBatch,
}

impl Table {
    /// The table of `columns` with the rows that `add` adds.
    pub fn of(
        columns: robhaz_record::Table,
        add: impl FnOnce(&mut BatchBuilder) -> PyResult<()>,
    ) -> PyResult<Self> {
        let name = columns.name.clone();
        let mut rows = BatchBuilder::new(columns, &[]);
        add(&mut rows)?;
        let batch = rows.take();
        let batch = batch.map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        Ok(Self { name, batch })
    }

    /// A value of every column's metadata, by the columns' names.
    fn metadata<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for field in self.batch.schema().fields() {
            values.set_item(field.name(), field.metadata().get(key))?;
        }
        Ok(values)
    }
}

#[pymethods]
impl Table {
    #[getter]
    fn columns(&self) -> Vec<String> {
        let schema = self.batch.schema();
        schema.fields().iter().map(|f| f.name().clone()).collect()
    }

    fn keys(&self) -> Vec<String> {
        self.columns()
    }

    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.metadata(py, "unit")
    }

    #[getter]
    fn descriptions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.metadata(py, "description")
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __contains__(&self, column: &str) -> bool {
        self.batch.column_by_name(column).is_some()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.columns().into_pyobject(py)?.call_method0("__iter__")
    }

    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(array) = self.batch.column_by_name(column) else {
            let names = self.columns().join(", ");
            let text = format!(
                "table {}: no column {column:?}, allowed: {names}",
                self.name
            );
            return Err(PyKeyError::new_err(text));
        };
        if let Some(counts) = array.as_primitive_opt::<UInt32Type>() {
            let bytes = counts.values().iter().map(|v| v.to_ne_bytes());
            return array_of_bytes(py, bytes.collect::<Vec<_>>().as_flattened(), "uint32");
        }
        let Some(numbers) = array.as_primitive_opt::<Float64Type>() else {
            return Err(PyRuntimeError::new_err(format!(
                "column {column}: {} is not a number",
                array.data_type()
            )));
        };
        let values = numbers.iter().map(|v| v.unwrap_or(f64::NAN));
        let bytes: Vec<_> = values.map(f64::to_ne_bytes).collect();
        array_of_bytes(py, bytes.as_flattened(), "float64")
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.batch.schema().as_ref());
        let schema = schema.map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// A requested schema is a wish that a producer need not meet (Arrow PyCapsule interface).
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], self.batch.schema());
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = (self.batch.num_rows(), self.batch.num_columns());
        format!(
            "<robhaz.Table {}: {rows} rows, {columns} columns>",
            self.name
        )
    }
}

/// A NumPy array that owns a copy of `bytes`.
fn array_of_bytes<'py>(py: Python<'py>, bytes: &[u8], dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    numpy.call_method1("frombuffer", (PyByteArray::new(py, bytes), dtype))
}
