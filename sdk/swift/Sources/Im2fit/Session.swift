// SPDX-License-Identifier: Apache-2.0
import CIm2fit
import Foundation

/// What a call of the library failed with; `status` is its number in im2fit.h.
public struct Im2fitError: Error, CustomStringConvertible {
    public let status: Int32
    public let description: String
}

/// A value with its 95 % interval: mm, kg of weight.
public struct Estimate: Equatable {
    public let value, low, high: Float
}

/// The depth camera: upright pixels, the centre of pixel 0 is 0.
public struct Camera {
    public var width, height: Int32
    public var fx, fy, cx, cy: Float
    public init(width: Int32, height: Int32, fx: Float, fy: Float, cx: Float, cy: Float) {
        (self.width, self.height, self.fx, self.fy, self.cx, self.cy) = (width, height, fx, fy, cx, cy)
    }
}

/// The session after the latest frame that was processed. Names are those of im2fit.h: "TRACKING", "ARMS_CLOSE".
public struct Progress: Equatable {
    public let state: String
    public let guidance: [String]
    public let framesUsed: UInt64
}

/// How a session ended.
public enum Outcome {
    /// Values by name ("chest_girth").
    case measured([String: Estimate])
    case notMeasured(state: String, guidance: [String])
}

/// One person before one depth camera. One thread at a time, but `progress()` from any thread while the session lives.
public final class Session {
    private let handle: OpaquePointer

    /// `body` may be nil: then there is no JSON of the body and no avatar.
    public init(camera: Camera, tracker: URL, index: URL, body: URL? = nil) throws {
        var opened: OpaquePointer?
        let status: Int32 = tracker.path.withCString { tracker in
            index.path.withCString { index in
                Session.withOptional(body?.path) { body in
                    var settings = im2fit_settings()
                    im2fit_settings_init(&settings, MemoryLayout<im2fit_settings>.size)
                    settings.tracker_path = tracker
                    settings.index_path = index
                    settings.body_path = body
                    settings.width = camera.width
                    settings.height = camera.height
                    (settings.fx, settings.fy, settings.cx, settings.cy) = (camera.fx, camera.fy, camera.cx, camera.cy)
                    settings.live = 1
                    return im2fit_open(&settings, &opened)
                }
            }
        }
        guard status == 0, let opened = opened else {
            throw Im2fitError(status: status, description: String(cString: im2fit_last_error(nil)))
        }
        handle = opened
    }

    deinit { im2fit_close(handle) }

    /// Depth as ARKit and AVFoundation deliver it: 32-bit metres, NaN or 0 where there is none. `rotateDeg` makes it
    /// upright. `down`: which way gravity pulls in the axes of this picture (x right, y down, z forward), where known.
    public func push(metres: UnsafePointer<Float>, width: Int32, height: Int32, rowBytes: Int = 0, rotateDeg: Int32 = 0,
                     timeNs: Int64 = 0, sequence: UInt64 = 0, down: SIMD3<Float> = .zero) throws {
        var frame = im2fit_frame()
        im2fit_frame_init(&frame, MemoryLayout<im2fit_frame>.size)
        frame.pixels = UnsafeRawPointer(metres)
        frame.format = Int32(IM2FIT_FORMAT_F32)
        frame.width = width
        frame.height = height
        frame.rotate_deg = rotateDeg
        frame.row_bytes = rowBytes
        frame.time_ns = timeNs
        frame.sequence = sequence
        (frame.down_x, frame.down_y, frame.down_z) = (down.x, down.y, down.z)
        try check(im2fit_push_frame(handle, &frame))
    }

    public func progress() throws -> Progress {
        let result = try poll()
        return Progress(state: Session.text(im2fit_state_name(result.state)), guidance: Session.codes(result.guidance),
                        framesUsed: result.frames_used)
    }

    /// No more frames: measures with what there is.
    public func finish() throws -> Outcome {
        try check(im2fit_finish(handle))
        var result = try poll()
        guard result.measured == 1 else {
            return .notMeasured(state: Session.text(im2fit_state_name(result.state)),
                                guidance: Session.codes(result.guidance_seen))
        }
        let values = withUnsafeBytes(of: &result.measurements) { Array($0.bindMemory(to: im2fit_estimate.self)) }
        var measured: [String: Estimate] = [:]
        for (id, e) in values.enumerated() {
            measured[Session.text(im2fit_measurement_name(Int32(id)))] = Estimate(value: e.value, low: e.low, high: e.high)
        }
        return .measured(measured)
    }

    /// result.json (docs/result.md), whether measured or not.
    public func json() throws -> String {
        String(decoding: try bytes { im2fit_result_json(self.handle, $0?.assumingMemoryBound(to: CChar.self), $1, $2) },
               as: UTF8.self)
    }

    /// The person as .glb; needs a measurement and a body.
    public func avatar() throws -> Data {
        Data(try bytes { im2fit_avatar(self.handle, Int32(IM2FIT_AVATAR_GLB), $0, $1, $2) })
    }

    private func bytes(_ call: (UnsafeMutableRawPointer?, Int, UnsafeMutablePointer<Int>) -> Int32) throws -> [UInt8] {
        var size = 0
        let asked = call(nil, 0, &size)
        if asked != Int32(IM2FIT_ERROR_TOO_SMALL) { try check(asked) }
        var buffer = [UInt8](repeating: 0, count: size + 1)
        try check(buffer.withUnsafeMutableBytes { call($0.baseAddress, $0.count, &size) })
        return Array(buffer.prefix(size))
    }

    private func poll() throws -> im2fit_result {
        var result = im2fit_result()
        try check(im2fit_poll(handle, &result, MemoryLayout<im2fit_result>.size))
        return result
    }

    private func check(_ status: Int32) throws {
        guard status != 0 else { return }
        let own = Session.text(im2fit_last_error(handle))
        throw Im2fitError(status: status, description: own.isEmpty ? Session.text(im2fit_last_error(nil)) : own)
    }

    private static func codes(_ bits: UInt32) -> [String] {
        (0..<Int32(IM2FIT_GUIDANCE_COUNT)).filter { bits >> UInt32($0) & 1 == 1 }.map { text(im2fit_guidance_name($0)) }
    }

    private static func text(_ name: UnsafePointer<CChar>?) -> String { name.map { String(cString: $0) } ?? "" }

    private static func withOptional<T>(_ text: String?, _ body: (UnsafePointer<CChar>?) -> T) -> T {
        text.map { $0.withCString { body($0) } } ?? body(nil)
    }
}
