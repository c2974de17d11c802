// SPDX-License-Identifier: Apache-2.0
// What a session knows beside its progress: known facts, sizes, tape, mesh, and the names of things.
import CIm2fit
import Foundation

/// The version of the library, "1.0.0".
public func im2fitVersion() -> String { FitSession.text(im2fit_version()) }

/// Numbers of IM2FIT_SEX_...
public enum Sex: Int32, Sendable {
    case unknown = 0
    case woman = 1
    case man = 2
}

/// Facts that the person reports. They are used together with the frames. 0: not known. A standard deviation of 0 means that of
/// reported facts; for a weight from a scale, set 0.7.
public struct Known: Equatable, Sendable {
    public var statureMm, statureSdMm: Float
    public var weightKg, weightSdKg: Float
    public var ageYears, ageSdYears: Float  // add 0.5 to completed years
    public var sex: Sex
    public init(statureMm: Float = 0, statureSdMm: Float = 0, weightKg: Float = 0, weightSdKg: Float = 0,
                ageYears: Float = 0, ageSdYears: Float = 0, sex: Sex = .unknown) {
        (self.statureMm, self.statureSdMm, self.weightKg) = (statureMm, statureSdMm, weightKg)
        (self.weightSdKg, self.ageYears, self.ageSdYears, self.sex) = (weightSdKg, ageYears, ageSdYears, sex)
    }
}

/// A smoothed joint of the latest frame, for display: mm in the camera's axes of the upright picture.
public struct Joint: Equatable, Sendable {
    public let name: String        // "HE", "LS", ...: the person's own left and right
    public let position: SIMD3<Float>
    public let confidence: Float   // 0..1; below 0.25: inferred, not visible
}

/// A clothing size and its probability.
public struct SizeProbability: Equatable, Sendable {
    public let name: String
    public let probability: Float
}

/// A definition of the tape (docs/tape.md).
public struct TapeDefinition: Equatable, Sendable {
    public let id, name, unit: String
    public let iso: String         // clause of ISO 8559-1:2017, or ""
}

/// The value of a definition of the tape for the person.
public enum TapeValue: Equatable, Sendable {
    case measured(Estimate)
    case refused(reason: String)
}

/// The reason why no person is found in a frame.
public struct Diagnosis: Equatable, Sendable {
    public let code: String        // "UNIT"; "" where nothing is wrong
    public let text: String        // what it looks like and what to do, in English
    public let unitMm: Float       // of UNIT and PLAYER_BITS: millimetres per unit; 0: not known
    public let rotateDeg: Int32    // of ROTATED: the rotation that makes the picture upright
}

/// A mesh in mm, the soles on y = 0.
public struct Mesh: Equatable, Sendable {
    public let vertices: [Float]   // x y z of each
    public let triangles: [Int32]  // three vertex indices each
}

/// A garment (docs/garments.md): "t_shirt", "T-shirt".
public struct Garment: Equatable, Sendable {
    public let id, name: String
}

/// A node that a `Rig` moves; `parent`: its index in `rigNodes()`, -1 for the first.
public struct RigNode: Equatable, Sendable {
    public let name: String
    public let parent: Int32
}

/// All definitions of the tape, named in "en", "de", "es", "fr" or "zh"; another language has no names ("").
public func tapeDefinitions(language: String = "en") -> [TapeDefinition] {
    (0..<im2fit_tape_count()).map { index in
        TapeDefinition(id: FitSession.text(im2fit_tape_id(index)),
                       name: FitSession.text(im2fit_tape_name(index, language)),
                       unit: FitSession.text(im2fit_tape_unit(index)),
                       iso: FitSession.text(im2fit_tape_iso(index)))
    }
}

/// All garments, named as `tapeDefinitions`.
public func garments(language: String = "en") -> [Garment] {
    (0..<im2fit_garment_count()).map { index in
        Garment(id: FitSession.text(im2fit_garment_id(index)), name: FitSession.text(im2fit_garment_name(index, language)))
    }
}

/// The nodes of an avatar, in the order of `Rig.rotations`.
public func rigNodes() -> [RigNode] {
    (0..<Int32(IM2FIT_RIG_NODE_COUNT)).map { node in
        RigNode(name: FitSession.text(im2fit_rig_node_name(node)), parent: im2fit_rig_node_parent(node))
    }
}

/// "mm" or "kg", of a measurement by its name ("chest_girth"); nil for another name.
public func unit(ofMeasurement name: String) -> String? {
    (0..<Int32(IM2FIT_MEASUREMENT_COUNT)).first { FitSession.text(im2fit_measurement_name($0)) == name }
        .map { FitSession.text(im2fit_measurement_unit($0)) }
}

extension Im2fitError {
    /// The short name of the status: "not_found".
    public var statusName: String { FitSession.text(im2fit_status_name(status)) }
}

extension FitSession {
    /// Waits until all pushed frames are processed. False after `timeoutMs`; negative: no limit.
    public func wait(timeoutMs: Int32 = -1) throws -> Bool {
        let status = im2fit_wait(handle, timeoutMs)
        if status == Int32(IM2FIT_ERROR_TIMEOUT.rawValue) { return false }
        try check(status)
        return true
    }

    /// Begins a session for a new person and discards all frames.
    public func reset() throws { try check(im2fit_reset(handle)) }

    /// Measures only people whose feet are within this rectangle on the floor. Coordinates are relative to the point under the
    /// camera: x to the camera's right, z away from it. Without arguments: everywhere.
    public func setRegion(x0Mm: Float = 0, z0Mm: Float = 0, x1Mm: Float = 0, z1Mm: Float = 0) throws {
        try check(im2fit_set_region(handle, x0Mm, z0Mm, x1Mm, z1Mm))
    }

    /// From now on, measures only the person with this `FitProgress.userId`; 0: the first person with empty guidance.
    public func selectUser(_ userId: Int32) throws { try check(im2fit_select_user(handle, userId)) }

    /// Sets facts that the person reports, before, during or after the frames. `finish()` then returns changed measurements.
    public func setKnown(_ facts: Known) throws {
        var known = im2fit_known()
        im2fit_known_init(&known, MemoryLayout<im2fit_known>.size)
        (known.stature_mm, known.stature_sd_mm) = (facts.statureMm, facts.statureSdMm)
        (known.weight_kg, known.weight_sd_kg) = (facts.weightKg, facts.weightSdKg)
        (known.age_years, known.age_sd_years) = (facts.ageYears, facts.ageSdYears)
        known.sex = facts.sex.rawValue
        try check(im2fit_set_known(handle, &known))
    }

    /// The joints of the latest frame, for display; empty without a person. Any thread.
    public func joints() throws -> [Joint] {
        let result = try poll()
        guard result.has_joints == 1 else { return [] }
        let joints = withUnsafeBytes(of: result.display_joints) { Array($0.bindMemory(to: im2fit_joint.self)) }
        return joints.enumerated().map { number, joint in
            Joint(name: FitSession.text(im2fit_joint_name(Int32(number))), position: SIMD3(joint.x, joint.y, joint.z),
                  confidence: joint.confidence)
        }
    }

    /// The sizes of the chart, small to large, and the index of the most probable one. Needs a measurement.
    public func sizes() throws -> (sizes: [SizeProbability], best: Int) {
        var count = 0
        var best = 0
        let status = im2fit_sizes(handle, nil, 0, &count, nil)
        if status != Int32(IM2FIT_ERROR_TOO_SMALL.rawValue) { try check(status) }
        var sizes = [im2fit_size](repeating: im2fit_size(), count: count)
        try check(im2fit_sizes(handle, &sizes, count, &count, &best))
        return (sizes.map { size in
            let name = withUnsafeBytes(of: size.name) { String(decoding: $0.prefix { $0 != 0 }, as: UTF8.self) }
            return SizeProbability(name: name, probability: size.probability)
        }, best)
    }

    /// All measurements of the tape by id. Needs a measurement and a body.
    public func tape() throws -> [String: TapeValue] {
        var values = [im2fit_tape_value](repeating: im2fit_tape_value(), count: im2fit_tape_count())
        try check(im2fit_tape(handle, nil, values.count, &values, MemoryLayout<im2fit_tape_value>.stride))
        var tape: [String: TapeValue] = [:]
        for (index, value) in values.enumerated() {
            tape[FitSession.text(im2fit_tape_id(index))] = value.status == Int32(IM2FIT_TAPE_MEASURED.rawValue)
                ? .measured(Estimate(value: value.value, low: value.low, high: value.high))
                : .refused(reason: FitSession.text(value.reason))
        }
        return tape
    }

    /// The person as a mesh in the measured pose. Needs a measurement and a body.
    public func mesh() throws -> Mesh {
        var vertexCount = 0
        var triangleCount = 0
        try check(im2fit_body_mesh(handle, nil, 0, &vertexCount, nil, 0, &triangleCount))
        var vertices = [Float](repeating: 0, count: 3 * vertexCount)
        var triangles = [Int32](repeating: 0, count: 3 * triangleCount)
        try check(im2fit_body_mesh(handle, &vertices, vertexCount, &vertexCount, &triangles, triangleCount, &triangleCount))
        return Mesh(vertices: vertices, triangles: triangles)
    }

    /// Differences between the measurements of the mesh and the person's, by name: mm, weight in kg.
    public func residual() throws -> [String: Float] {
        var values = [Float](repeating: 0, count: Int(IM2FIT_MEASUREMENT_COUNT))
        try check(im2fit_body_residual(handle, &values))
        var residual: [String: Float] = [:]
        for (id, value) in values.enumerated() { residual[FitSession.text(im2fit_measurement_name(Int32(id)))] = value }
        return residual
    }
}
