// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt and sample-app name of it, to compile against.
package android.content;

public class Context {
  public static final String CAMERA_SERVICE = "camera", SENSOR_SERVICE = "sensor";
  public Object getSystemService(String name) { return null; }
  public int checkSelfPermission(String permission) { return 0; }
  public android.content.res.AssetManager getAssets() { return null; }
}
