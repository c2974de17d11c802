// SPDX-License-Identifier: Apache-2.0
package im2fit.sampleapp

import android.Manifest
import android.content.pm.PackageManager
import android.os.Bundle
import android.os.Handler
import android.os.HandlerThread
import androidx.activity.ComponentActivity
import androidx.activity.compose.setContent
import androidx.activity.result.contract.ActivityResultContracts
import androidx.compose.runtime.mutableStateOf
import im2fit.sample.ofAssets
import im2fit.sdk.Models
import java.util.Locale

/** The app's one screen. Its model pack is the asset im2fit-models.i2p, stored without compression (docs/models.md). */
class MainActivity : ComponentActivity() {
    private val camera = HandlerThread("depth camera")
    private val shown = mutableStateOf<Shown?>(null)
    private lateinit var measuring: Measuring
    private val permission = registerForActivityResult(ActivityResultContracts.RequestPermission()) { measuring.granted(it) }

    override fun onCreate(savedInstanceState: Bundle?) {
        super.onCreate(savedInstanceState)
        camera.start()
        measuring = Measuring(this, openedModels(), Handler(camera.looper), { runOnUiThread(it) }, { shown.value = it })
        if (checkSelfPermission(Manifest.permission.CAMERA) == PackageManager.PERMISSION_GRANTED) measuring.granted(true)
        shown.value = measuring.shown
        val actions = Actions(
            ask = { permission.launch(Manifest.permission.CAMERA) }, start = { measuring.start(it) },
            stop = { measuring.stop() }, delete = { measuring.delete() }
        )
        setContent { shown.value?.let { SampleApp(it, language(), actions) } }
    }

    override fun onStop() {
        measuring.leave()
        super.onStop()
    }

    override fun onDestroy() {
        measuring.close()
        camera.quitSafely()
        super.onDestroy()
    }

    private fun openedModels(): ModelSource = { use -> Models.ofAssets(assets, "im2fit-models.i2p", use) }

    /** One of the languages that the library has texts in. */
    private fun language(): String = Locale.getDefault().language.takeIf { it in listOf("de", "es", "fr", "zh") } ?: "en"
}
